"""``learn --log LOG.mat`` of version 5."""

from __future__ import annotations

import io
import struct
import zlib
from pathlib import Path
from random import Random

import numpy as np
import scipy.io

from stickslip.errors import RecordingError
from stickslip.logs.file import read_table

EXPECTED = (RecordingError,)
_HEADER = 128
_SIZES = (0, 1, 2, 4, 5, 6, 7, 9, 14, 15, 255, 2**16, 2**31 - 1, 2**31, 2**32 - 8, 2**32 - 1)


def _packed(content: dict[str, object], *, compressed: bool = False) -> bytes:
    stream = io.BytesIO()
    scipy.io.savemat(stream, content, do_compression=compressed)
    return stream.getvalue()


def corpus() -> list[bytes]:
    t = np.arange(30) * 1e-3
    log = {"t": t, "x": np.sin(t)[:, None], "kp": 3.0}
    kinds = {
        "s": {"t": t, "inner": {"x": t, "deep": {"y": t.astype(np.float32)}}},
        "text": "abc",
        "cells": np.array(["a", 1], dtype=object),
        "z": t * 1j,
        "m": np.arange(12, dtype=np.int16).reshape(3, 4),
        "cube": np.zeros((2, 2, 2), np.uint8),
        "flag": np.array([True, False]),
        "none": np.zeros((0, 3)),
    }
    return [_packed(log), _packed(log, compressed=True), _packed(kinds), _packed({"x": t})]


def parse(data: bytes, folder: Path) -> None:
    file = folder / "log.mat"
    file.write_bytes(data)
    read_table(file)


def mutate(rng: Random, data: bytes) -> bytes:
    """Change words of four bytes; pack the elements afterwards, or unpack and pack them again."""
    head, body = data[:_HEADER], bytearray(data[_HEADER:])
    if len(body) > 8 and body[0] == 15:
        body = bytearray(zlib.decompress(body[8:]))
    for _ in range(rng.randint(1, 3)):
        place = 4 * rng.randrange(max(1, min(len(body), 400) // 4))
        word = rng.choice(_SIZES) if rng.random() < 0.7 else rng.getrandbits(32)
        body[place : place + 4] = struct.pack("<I", word)
    if rng.random() < 0.3:
        packed = zlib.compress(bytes(body))
        body = bytearray(struct.pack("<II", 15, len(packed)) + packed)
    return head + bytes(body)
