"""Parquet files, as logs and as inputs."""

from __future__ import annotations

import io
from pathlib import Path
from random import Random

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from stickslip import cosim
from stickslip.errors import RecordingError
from stickslip.logs.file import read_table

EXPECTED = (cosim.SignalError, RecordingError)


def _packed(columns: dict[str, object], **how: object) -> bytes:
    stream = io.BytesIO()
    pq.write_table(pa.table(columns), stream, **how)
    return stream.getvalue()


def corpus() -> list[bytes]:
    t = np.arange(64) * 1e-3
    plain = {"time": t, "x": np.sin(9 * t), "n": np.arange(64) % 3}
    kinds = {
        "time": pa.array(range(20), pa.timestamp("us")),
        "x": pa.array([None, *range(19)], pa.float32()),
        "text": ["a"] * 20,
        "nested": [{"a": k, "b": [k] * 3} for k in range(20)],
        "flag": [True, False] * 10,
        "decimal": pa.array(range(20)).cast(pa.decimal128(30, 2)),
    }
    small = {"time": [0.0, 1.0], "u": [1, 2]}
    return [
        _packed(plain, compression="none", use_dictionary=False),
        _packed(plain),
        _packed(plain, compression="zstd", row_group_size=20, data_page_version="2.0"),
        _packed(plain, compression="gzip", use_dictionary=["n"], write_statistics=False),
        _packed(kinds, compression="none"),
        _packed(small, compression="none", store_schema=False),
        _packed(
            small,
            compression="lz4",
            use_dictionary=False,
            column_encoding={"time": "BYTE_STREAM_SPLIT", "u": "DELTA_BINARY_PACKED"},
        ),
    ]


def parse(data: bytes, folder: Path) -> None:
    file = folder / "in.parquet"
    file.write_bytes(data)
    try:
        read_table(file)
    finally:
        cosim.read_tables(file)


def mutate(rng: Random, data: bytes) -> bytes:
    """Change numbers of the description at the end, or of one page, and nothing else."""
    size = int.from_bytes(data[-8:-4], "little")
    begin = len(data) - 8 - size
    changed = bytearray(data)
    first, last = (begin, len(data) - 8) if rng.random() < 0.6 else (4, begin)
    for _ in range(rng.randint(1, 3)):
        changed[rng.randrange(first, last)] = rng.choice((0, 1, 2, 0x7F, 0xFF, rng.randrange(256)))
    return bytes(changed)
