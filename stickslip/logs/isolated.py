"""A log read by a library in a process of its own, see ``reader_process``."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np

from stickslip.errors import RecordingError
from stickslip.fmi.process import child_process
from stickslip.logs import reader_process
from stickslip.logs.signals import Signal

TIMEOUT = 60.0  # time limit of the reader [s]


def read_isolated(path: str, data: bytes, module: str, title: str) -> list[Signal] | str:
    """Return the signals of a file, or its table as text.

    Raises RecordingError when the file is damaged, takes too long or too much memory.

    Parameters
    ----------
    path : for messages
    data : content of the file
    module : path of the module whose ``contents`` reads it
    title : of the format, for messages
    """
    search = {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p), "OPENBLAS_NUM_THREADS": "1"}
    pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    command = [sys.executable, "-P", str(Path(reader_process.__file__)), module]
    with child_process(command, env=os.environ | search, **pipes) as process:
        try:
            output, errors = process.communicate(data, TIMEOUT)
            begin = output.find(b"PK\x03\x04")  # Python may print as it starts
            with np.load(io.BytesIO(output[begin:]), allow_pickle=False) as found:
                described = json.loads(found["signals"].item())
                if described is None:
                    return bytes(found["arr_0"]).decode()
                arrays = [found[f"arr_{k}"] for k in range(len(found.files) - 1)]
                return [
                    Signal(
                        name,
                        None if place is None else arrays[place],
                        unit=unit,
                        time=None if time is None else arrays[time],
                        instead=instead,
                    )
                    for name, unit, place, instead, time in described
                ]
        except subprocess.TimeoutExpired:
            reason = f"not read within {TIMEOUT:g} s"
        except (ValueError, OSError, KeyError, EOFError, zipfile.BadZipFile):
            last = errors.decode("utf-8", "replace").strip().splitlines()[-1:]
            reason = last[0][:80] if last else f"its reader ended with {process.returncode}"
    raise RecordingError(f"{path}: cannot be read as {title}, perhaps it is damaged ({reason})")
