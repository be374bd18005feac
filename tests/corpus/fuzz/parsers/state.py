"""``simulate --resume STATE``."""

from __future__ import annotations

import zipfile
from io import BytesIO
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory

import numpy as np

from stickslip import cosim
from stickslip.cosim.run.checkpoint import Checkpoint
from tests.corpus.fuzz.mutation import mutated

EXPECTED = (cosim.SimulationError,)


def corpus() -> list[bytes]:
    row, memory = np.arange(3.0), {"a/times": np.zeros(2), "/x": np.ones(4)}
    saved = Checkpoint({"step": "0.1"}, 5, row, {"a": b"state"}, {"a.k": 2.0}, memory)
    with TemporaryDirectory() as folder:
        return [saved.write(Path(folder) / "state").read_bytes()]


def parse(data: bytes, folder: Path) -> None:
    file = folder / "state"
    file.write_bytes(data)
    Checkpoint.read(file)


def mutate(rng: Random, data: bytes) -> bytes:
    """Change one member and pack all again."""
    stream = BytesIO()
    with zipfile.ZipFile(BytesIO(data)) as old, zipfile.ZipFile(stream, "w") as new:
        names = old.namelist()
        for name, changed in zip(names, rng.sample(names, len(names)), strict=True):
            content = old.read(name)
            new.writestr(name, mutated(rng, content, [content]) if name == changed else content)
    return stream.getvalue()
