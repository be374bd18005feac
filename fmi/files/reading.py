"""Untrusted files: regular files only, read up to a limit."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import re
import stat
import tomllib
from collections import Counter
from io import BufferedReader
from typing import Any

DEEPEST = 32
"""Lists and tables within each other, and names joined by dots."""
MOST_TEXT = 1 << 25
"""Bytes of a document."""

_STRINGS = re.compile(
    r'"""(?:\\.|[^\\])*?"""|\'\'\'.*?\'\'\'|"(?:\\.|[^"\\\n])*+"|\'[^\'\n]*+\'|#[^\n]*+', re.DOTALL
)
_BITS = 1023
_BETWEEN_KEYS = re.compile(r"[,{}\[\]=\n]")


def read_limited(path: str | os.PathLike[str], most: int) -> bytes:
    """Return what a file holds; OSError where it has more bytes than ``most``."""
    with open_regular_file(path) as file:
        stated = os.fstat(file.fileno()).st_size
        data = file.read(most + 1) if stated <= most else b""
        size = max(stated, len(data))  # of some files the system says 0
        if size > most:
            said = f"{size} bytes, at most {most} are read; take a part of it"
            raise _refused(errno.EFBIG, said, path)
    return data


def digest(path: str | os.PathLike[str]) -> str:
    """Return the SHA-256 of what a file holds, in hexadecimal."""
    with open_regular_file(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def open_regular_file(path: str | os.PathLike[str]) -> BufferedReader:
    """Open a regular file; OSError where it is none: a pipe or a device may never end."""
    flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    try:
        number = os.open(path, flags)
    except ValueError:  # NUL, or half a character
        raise _refused(errno.EINVAL, "no name that a file can have", path) from None
    if not stat.S_ISREG(os.fstat(number).st_mode):
        os.close(number)
        raise _refused(errno.EINVAL, "no regular file; write it to one first", path)
    return os.fdopen(number, "rb")


def parse_json(data: bytes) -> Any:
    """Return the content of JSON in UTF-8.

    ValueError where it is none, names a key twice, holds NaN or Infinity, or is nested too deeply.
    """
    text = _text(data)
    try:
        content = json.loads(text, object_pairs_hook=_distinct, parse_constant=_no_number)
    except RecursionError:
        raise _too_deep() from None
    _check_extent(content)
    return content


def parse_toml(data: bytes) -> dict[str, Any]:
    """Return the content of TOML; ValueError where it is none, or is nested too deeply."""
    text = _text(data)
    # tomllib takes minutes for a name of 100,000 parts
    if any(part.count(".") > DEEPEST for part in _BETWEEN_KEYS.split(_STRINGS.sub("", text))):
        raise _too_deep()
    try:
        content = tomllib.loads(text)
    except RecursionError:
        raise _too_deep() from None
    _check_extent(content)
    return content


def _text(data: bytes) -> str:
    """Return text in UTF-8; what else is no text is said shortly."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        line = data.count(b"\n", 0, fault.start) + 1
        raise ValueError(f"line {line}: byte 0x{data[fault.start]:02x} is no UTF-8") from None


def _distinct(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    content = dict(pairs)
    if len(content) < len(pairs):
        twice = Counter(name for name, _ in pairs).most_common(1)[0][0]
        raise ValueError(f"{twice[:80]!r} is there twice")
    return content


def _no_number(name: str) -> Any:
    raise ValueError(f"{name} is no number of JSON")


def _check_extent(content: object) -> None:
    """Check that content is not nested too deeply and that its integers can become floats."""
    level = [content]
    for _ in range(DEEPEST + 1):
        if any(isinstance(x, int) and x.bit_length() >= _BITS for x in level):
            raise ValueError("holds a number beyond 1e308")
        lists = [x for x in level if isinstance(x, list)]
        lists += [list(x.values()) for x in level if isinstance(x, dict)]
        level = [inner for part in lists for inner in part]
        if not level:
            return
    raise _too_deep()


def _too_deep() -> ValueError:
    return ValueError(f"nested too deeply; at most {DEEPEST} levels are read")


def _refused(number: int, said: str, path: str | os.PathLike[str]) -> OSError:
    return OSError(number, said, os.fspath(path))
