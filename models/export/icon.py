"""The icon of a model: lines of model.toml on a tile, as SVG and as PNG."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Line = Sequence[float]
"""A polyline x1, y1, x2, y2 ... on a tile of 100 by 100, y downwards."""

_SIZE = 128  # pixels
_STROKE = 5.0  # of 100
_EDGE, _CORNER = 3.0, 14.0
_TILE, _INK = (240, 244, 248), (24, 62, 96)


def svg(lines: Sequence[Line]) -> str:
    """Return the icon as SVG."""
    paths = "".join(
        f'<polyline points="{" ".join(f"{x:g},{y:g}" for x, y in _points(line))}"/>'
        for line in lines
    )
    inside = 100 - 2 * _EDGE
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100">'
        f'<g fill="none" stroke="#{_hex(_INK)}" stroke-width="{_STROKE:g}"'
        ' stroke-linecap="round" stroke-linejoin="round">'
        f'<rect x="{_EDGE:g}" y="{_EDGE:g}" width="{inside:g}" height="{inside:g}"'
        f' rx="{_CORNER:g}" fill="#{_hex(_TILE)}" stroke-width="{_STROKE / 2:g}"/>'
        f"{paths}</g></svg>\n"
    )


def png(lines: Sequence[Line]) -> bytes:
    """Return the icon as PNG, 128 by 128, with alpha."""
    x, y = np.meshgrid(*2 * [(np.arange(_SIZE) + 0.5) * 100.0 / _SIZE])
    # Distance to the tile's outline, negative inside.
    half = 50.0 - _EDGE - _CORNER
    qx, qy = np.abs(x - 50.0) - half, np.abs(y - 50.0) - half
    outline = np.hypot(np.maximum(qx, 0), np.maximum(qy, 0)) + np.minimum(np.maximum(qx, qy), 0)
    outline -= _CORNER
    ink = _STROKE / 4 - np.abs(outline)
    for line in lines:
        points = _points(line)
        for a, b in pairwise(points):
            ink = np.maximum(ink, _STROKE / 2 - _distance(x, y, a, b))
    inked, tiled = _coverage(ink), _coverage(_STROKE / 4 - outline)
    pixels = np.empty((_SIZE, _SIZE, 4), np.uint8)
    for channel in range(3):
        pixels[..., channel] = np.rint(_TILE[channel] + inked * (_INK[channel] - _TILE[channel]))
    pixels[..., 3] = np.rint(255 * np.maximum(inked, tiled))
    rows = np.insert(pixels.reshape(_SIZE, -1), 0, 0, axis=1)  # each row begins with its filter
    head = struct.pack(">IIBBBBB", _SIZE, _SIZE, 8, 6, 0, 0, 0)
    chunks = ((b"IHDR", head), (b"IDAT", zlib.compress(rows.tobytes(), 9)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(*chunk) for chunk in chunks)


def _points(line: Line) -> list[tuple[float, float]]:
    return list(zip(line[::2], line[1::2], strict=True))


def _coverage(depth: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how much of a pixel is covered whose centre lies that deep inside."""
    return np.clip(depth * _SIZE / 100.0 + 0.5, 0.0, 1.0)


def _distance(
    x: NDArray[np.float64], y: NDArray[np.float64], a: tuple[float, float], b: tuple[float, float]
) -> NDArray[np.float64]:
    """Return the distance to the segment from a to b."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    along = np.clip(((x - a[0]) * dx + (y - a[1]) * dy) / (dx * dx + dy * dy or 1.0), 0.0, 1.0)
    return np.hypot(x - a[0] - along * dx, y - a[1] - along * dy)


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def _hex(colour: tuple[int, int, int]) -> str:
    return "".join(f"{part:02x}" for part in colour)
