"""The text of a message with the arguments that follow it, as FMI 2.0 lets an FMU pass them.

A callback in Python has no variable arguments. It is declared with as many further ones as the
system passes in registers and, beyond them, in eight words of the caller's stack.
"""

from __future__ import annotations

import ctypes
import platform
import re
import struct
import sys
from collections.abc import Sequence
from ctypes import c_double, c_uint64
from typing import Any

_SPEC = re.compile(
    rb"%(?P<flags>[-+ #0]*)(?P<width>\*|\d*)(?:\.(?P<digits>\*|\d*))?"
    rb"(?:hh|h|(?P<long>ll|l|j|z|t)|L)?(?P<kind>[diouxXcspfFeEgGaA%])"
)
_MOST_WIDTH = 1000
_ON_STACK = 8
_TOGETHER = sys.platform == "win32"
"""Whether floating-point numbers lie among the others."""
_REGISTERS = {"x86_64": (1, 8), "AMD64": (1, 8), "aarch64": (3, 8)}.get(platform.machine())
KNOWN = _REGISTERS is not None and sys.platform in ("linux", "win32")
_N, _N_FLOATS = (_REGISTERS or (0, 0)) if not _TOGETHER else (0, 0)
ARGUMENTS: tuple[Any, ...] = (
    (*[c_uint64] * (_N + _ON_STACK), *[c_double] * _N_FLOATS) if KNOWN else ()
)
"""C types of what follows the format."""


def formatted(text: bytes, arguments: Sequence[float]) -> bytes:
    """Return a format with its arguments, which are those of ``ARGUMENTS``.

    What it asks for beyond them stays as it is written.
    """
    words = iter([int(word) for word in arguments[: _N + _ON_STACK]])
    floats = iter(arguments[_N + _ON_STACK :])

    def size(given: bytes | None) -> bytes:
        number = _signed(next(words), 32) if given == b"*" else int(given or 0)
        return str(max(-_MOST_WIDTH, min(_MOST_WIDTH, number))).encode()

    def one(found: re.Match[bytes]) -> bytes:
        kind = found["kind"]
        if kind == b"%":
            return b"%"
        spec: bytes = b"%" + found["flags"] + (size(found["width"]) if found["width"] else b"")
        spec += b"" if found["digits"] is None else b"." + size(found["digits"])
        if kind in b"fFeEgGaA":
            number = _double(next(words)) if _TOGETHER else next(floats)
            return number.hex().encode() if kind in b"aA" else (spec + kind) % number
        word = next(words)
        if kind == b"s":
            string: bytes = ctypes.c_char_p(word).value or b"(null)"
            return (spec + kind) % string
        if kind == b"c":
            return (spec + kind) % bytes([word & 0xFF])
        bits = 64 if found["long"] or kind == b"p" else 32
        if kind in b"di":
            return (spec + b"d") % _signed(word, bits)
        if kind == b"o":  # Python writes 0o for the 0 of C
            digits: bytes = (spec + kind) % (word % 2**bits)
            return digits.replace(b"0o", b"0", 1)
        spec += {b"p": b"#x", b"u": b"d"}.get(kind, kind)
        shown: bytes = spec % (word % 2**bits)
        return shown

    try:
        return _SPEC.sub(one, text) if KNOWN else text
    except StopIteration:
        return text


def _double(word: int) -> float:
    number: float = struct.unpack("d", struct.pack("Q", word))[0]
    return number


def _signed(word: int, bits: int) -> int:
    word %= 2**bits
    return word - 2**bits if word >> (bits - 1) else word
