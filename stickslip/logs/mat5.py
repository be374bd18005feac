"""MAT files of version 5, as far as logs need them.

Read here and not by scipy, whose reader brings the whole process down on some damaged files.

Source: MathWorks, "MAT-File Format", level 5.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

HEADER = 128
MOST = 1 << 28
"""Bytes that all compressed variables together may have."""
MOST_PARTS = 32
"""Dimensions of an array; flags and lengths are fewer."""
DEEPEST = 8
"""Structs in structs."""

_MATRIX, _COMPRESSED = 14, 15
_NUMBERS = {
    1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8",
}  # fmt: skip
_CLASSES = {
    1: "a cell array", 2: "an array of structs", 3: "an object", 4: "text", 5: "a sparse matrix",
    16: "a function", 17: "an object",
}  # fmt: skip
_STRUCT, _FIRST_NUMBER, _LAST_NUMBER = 2, 6, 15
_COMPLEX = 0x0800


class DamagedError(ValueError):
    """The bytes are no MAT file of version 5."""


@dataclass(frozen=True)
class Other:
    """A variable that holds no real numbers; ``kind`` says what."""

    kind: str


Variable = NDArray[Any] | dict[str, Any] | Other
"""Numbers in the shape they have, a struct of one element, or something else."""


def read_variables(data: bytes) -> dict[str, Variable]:
    """Return the variables of a file by name.

    Raises
    ------
    DamagedError
        When the bytes are no such file.
    """
    orders = {b"IM": "<", b"MI": ">"}
    order = orders.get(data[HEADER - 2 : HEADER])
    if order is None:
        raise DamagedError("no header of version 5")
    variables, left = {}, MOST
    for kind, content in _elements(memoryview(data)[HEADER:], order):
        if kind == _COMPRESSED:
            whole = _inflated(content, left)
            left -= len(whole)
            inner = list(_elements(memoryview(whole), order))
        else:
            inner = [(kind, content)]
        for inner_kind, inner_content in inner:
            if inner_kind == _MATRIX and inner_content:
                name, variable = _matrix(inner_content, order, 0)
                variables[name] = variable
    return variables


def _elements(data: memoryview, order: str) -> Iterator[tuple[int, memoryview]]:
    """Yield type and content of the elements that lie one behind another."""
    at = 0
    while at + 8 <= len(data):
        first, size = struct.unpack_from(order + "II", data, at)
        if first >> 16:  # four bytes or less lie in the tag itself
            kind, size, begin = first & 0xFFFF, first >> 16, at + 4
            if size > 4:
                raise DamagedError(f"an element of {size} bytes where 4 have room")
            at += 8
        else:
            kind, begin = first, at + 8
            at = begin + size + (0 if kind == _COMPRESSED else -size % 8)
        if begin + size > len(data):
            raise DamagedError("it ends within a variable")
        yield kind, data[begin : begin + size]


def _inflated(data: memoryview, most: int) -> bytes:
    inflater = zlib.decompressobj()
    try:
        content = inflater.decompress(data, most + 1)
    except zlib.error as error:
        raise DamagedError(f"compressed data: {error}") from None
    if len(content) > most:
        raise DamagedError(f"variables of more than {MOST} bytes")
    return content


def _matrix(data: memoryview, order: str, depth: int) -> tuple[str, Variable]:
    """Return name and content of an array."""
    parts = _elements(data, order)
    flags = _integers(parts, order)
    shape = _integers(parts, order)
    name = _text(_next(parts)[1])
    if not flags or len(shape) < 2 or min(shape) < 0:
        raise DamagedError(f"no array where one should be ({name!r})")
    which = flags[0] & 0xFF
    count = math.prod(shape)
    if which == _STRUCT and count == 1 and depth < DEEPEST:
        return name, _fields(parts, order, depth)
    if not _FIRST_NUMBER <= which <= _LAST_NUMBER:
        return name, Other(_CLASSES.get(which, "something unknown"))
    if flags[0] & _COMPLEX:
        return name, Other("complex numbers")
    kind, content = _next(parts)
    if kind not in _NUMBERS:
        raise DamagedError(f"'{name}' holds no numbers")
    dtype = np.dtype(order + _NUMBERS[kind])
    if len(content) != count * dtype.itemsize:
        raise DamagedError(f"'{name}' of shape {shape} has {len(content)} bytes")
    return name, np.frombuffer(content, dtype).reshape(shape, order="F")


def _fields(parts: Iterator[tuple[int, memoryview]], order: str, depth: int) -> dict[str, Any]:
    lengths = _integers(parts, order)
    text = _next(parts)[1]
    if len(lengths) != 1 or lengths[0] < 1:
        raise DamagedError("a struct without the length of its names")
    return {
        _text(text[k : k + lengths[0]]): _matrix(_next(parts)[1], order, depth + 1)[1]
        for k in range(0, len(text), lengths[0])
    }


def _integers(parts: Iterator[tuple[int, memoryview]], order: str) -> list[int]:
    content = _next(parts)[1]
    if len(content) > 4 * MOST_PARTS:
        raise DamagedError(f"{len(content) // 4} dimensions or flags")
    return list(struct.unpack(f"{order}{len(content) // 4}i", content[: len(content) // 4 * 4]))


def _next(parts: Iterator[tuple[int, memoryview]]) -> tuple[int, memoryview]:
    if (part := next(parts, None)) is None:
        raise DamagedError("an array ends too early")
    return part


def _text(content: memoryview) -> str:
    """Return a name, which a NUL may end."""
    return bytes(content).split(b"\0")[0].decode("latin-1")
