"""Logs as MAT files, which ``mat_reader`` reads in a process of its own."""

from __future__ import annotations

import io
import os
import subprocess
import sys
import zipfile

import numpy as np

from stickslip.errors import RecordingError
from stickslip.fmi.process import child_process
from stickslip.logs import mat_reader
from stickslip.logs.table import LogTable
from stickslip.servo.measurement import Array

TIMEOUT = 60.0
"""Time limit of the reader [s]."""


def recognises(data: bytes, suffix: str) -> bool:
    """Tell whether a log is of this format."""
    return data.startswith((b"MATLAB ", b"\x89HDF")) or suffix == ".mat"


def read(path: str, data: bytes) -> LogTable:
    """Read the vectors and scalars of a MAT file; fields of structs are called ``struct.field``.

    Raises
    ------
    RecordingError
        When it cannot be read or holds no vector of numbers.
    """
    numbers: dict[str, Array] = {}
    scalars: dict[str, float] = {}
    faults: dict[str, str] = {}
    for name, found in _variables(path, data).items():
        if found.dtype.kind == "U":
            faults[name] = f"expected a vector of numbers, got {found}"
            continue
        with np.errstate(invalid="ignore"):  # signalling NaN
            value = found.astype(np.float64)
        if value.size == 1:
            scalars[name] = float(value.ravel()[0])
        elif value.ndim == 2 and min(value.shape) > 1:  # one signal a column
            matrix = value if value.shape[0] >= value.shape[1] else value.T
            for k, column in enumerate(matrix.T, start=1):
                numbers[f"{name}({k})"] = column
        elif value.ndim <= 2 and value.size:
            numbers[name] = value.ravel()
        else:
            faults[name] = f"expected a vector, got an array {value.shape}"
    if not numbers:
        names = ", ".join(sorted([*scalars, *faults])[:8]) or "nothing"
        raise RecordingError(f"{path}: no vectors of numbers; there is {names}")
    return LogTable(path, (*numbers, *faults), numbers, faults=faults, scalars=scalars)


def _variables(path: str, data: bytes) -> dict[str, np.ndarray]:
    search = {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p), "OPENBLAS_NUM_THREADS": "1"}
    pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    command = [sys.executable, "-P", mat_reader.__file__]
    with child_process(command, env=os.environ | search, **pipes) as process:
        try:
            output, errors = process.communicate(data, TIMEOUT)
            with np.load(io.BytesIO(output), allow_pickle=False) as found:
                names = found["names"].tolist()
                return {name: found[f"arr_{k}"] for k, name in enumerate(names)}
        except subprocess.TimeoutExpired:
            reason = f"not read within {TIMEOUT:g} s"
        except (ValueError, OSError, KeyError, EOFError, zipfile.BadZipFile):
            last = errors.decode("utf-8", "replace").strip().splitlines()[-1:]
            reason = last[0][:80] if last else f"its reader ended with {process.returncode}"
    raise RecordingError(
        f"{path}: not a MAT file, damaged, or of version 7.3 and h5py is not installed "
        f"({reason}); save it with save(..., '-v7')"
    )
