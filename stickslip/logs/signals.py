"""From signals, each with times of its own or none, to one table."""

import io
import json
import os
import subprocess
import sys
import zipfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stickslip.errors import RecordingError
from stickslip.fmi.messages import printable
from stickslip.fmi.process import child_process
from stickslip.logs import reader_process
from stickslip.logs.header import split_unit
from stickslip.logs.recording import Finding
from stickslip.logs.roles import role_named
from stickslip.logs.table import LogTable
from stickslip.servo.measurement import Array


@dataclass(frozen=True, eq=False)
class Signal:
    """A variable of a file."""

    name: str  # in the file
    values: Array | None  # numbers of any shape; None where there are none
    unit: str = ""  # as the file states it
    time: Array | None = None  # (n,) of its values [s]; None where the file has it elsewhere
    instead: str = ""  # what there is instead of numbers


def table_of(
    path: str,  # for messages
    signals: Iterable[Signal],  # in the file's order
    findings: tuple[Finding, ...] = (),  # of reading
    timed: str | None = "s",  # unit of their times
) -> LogTable:
    """Return one table of signals; what has other times is interpolated.

    Columns of a matrix are called ``name(1)`` and so on. The common times are those of the
    position, because one that is interpolated between its samples shows false accelerations;
    without a position those of the velocity, of the force, or of most samples. Raises
    RecordingError when there is no vector of numbers.
    """
    numbers: dict[str, Array] = {}
    times: dict[str, Array] = {}
    units: dict[str, str] = {}
    faults: dict[str, str] = {}
    scalars: dict[str, float] = {}
    names: dict[str, None] = {}
    for signal in signals:
        for name, column in _columns(signal):
            name, unit = split_unit(printable(name))
            while name in names:
                name = f"{name}_{len(names) + 1}"
            if isinstance(column, float):
                scalars[name] = column
                continue
            names[name] = None
            if unit := signal.unit.strip() or unit or "":
                units[name] = unit
            if isinstance(column, str):
                faults[name] = column
                continue
            numbers[name] = column
            if signal.time is not None:
                times[name] = np.asarray(signal.time, dtype=np.float64).ravel()
    if not numbers:
        first = next((f" ({name}: {fault})" for name, fault in faults.items()), "")
        listed = ", ".join(sorted([*scalars, *faults])[:8]) or "nothing"
        raise RecordingError(f"{path}: no vectors of numbers; there is {listed}{first}")
    if times:
        name = "time" if "time" not in names else "time of the signals"
        numbers[name], moved = _aligned(numbers, times, faults)
        findings = (*findings, *moved)
        names = {name: None, **names}
        if timed:
            units[name] = timed
    return LogTable(
        path,
        tuple(names),
        {name: column for name, column in numbers.items() if name not in faults},
        units=units,
        faults=faults,
        scalars=scalars,
        findings=findings,
    )


def _columns(signal: Signal) -> list[tuple[str, Array | float | str]]:
    """Return the vectors of a signal by name, a number, or what it is instead."""
    name = signal.name
    if signal.values is None:
        return [(name, f"expected a vector of numbers, got {printable(signal.instead)}")]
    with np.errstate(invalid="ignore"):  # signalling NaN
        value = signal.values.astype(np.float64)
    n = None if signal.time is None else signal.time.size
    if value.ndim == 3 and value.shape[-1] == n:  # one matrix a sample
        value = value.reshape(-1, value.shape[-1]).T
    if value.size == 1 and n is None:
        return [(name, float(value.ravel()[0]))]
    if value.ndim == 2 and min(value.shape) > 1:  # one signal a column
        upright = value.shape[0] == n or (value.shape[1] != n and value.shape[0] >= value.shape[1])
        columns = (value if upright else value.T).T
        return [(f"{name}({k})", column) for k, column in enumerate(columns, start=1)]
    if value.ndim > 2 or not value.size:
        return [(name, f"expected a vector, got an array {value.shape}")]
    if n not in (None, value.size):
        return [(name, f"{value.size} values, but {n} times")]
    return [(name, value.ravel())]


def _aligned(
    numbers: dict[str, Array], times: dict[str, Array], faults: dict[str, str]
) -> tuple[Array, tuple[Finding, ...]]:
    """Put all signals that have times on common ones; return these."""
    groups: dict[bytes, list[str]] = {}
    for name, t in times.items():
        groups.setdefault(t.tobytes(), []).append(name)

    def weight(names: list[str]) -> tuple[bool | int, ...]:
        roles = {found[0] for name in names if (found := role_named(name))}
        wanted = (role in roles for role in ("position", "velocity", "force"))
        return (*wanted, len(times[names[0]]))

    common = max(groups.values(), key=weight)
    base = times[common[0]]
    moved = []
    for names in groups.values():
        if names is common:
            continue
        t = times[names[0]]
        rises = bool(np.all(np.diff(t) > 0))
        for name in names:
            if not rises:
                faults[name] = "its times do not rise"
            else:
                numbers[name] = np.interp(base, t, numbers[name], left=np.nan, right=np.nan)
                moved.append(name)
    if not moved:
        return base, ()
    shown = ", ".join(moved[:6]) + (", ..." if len(moved) > 6 else "")
    what = f"signals with other times, interpolated to those of {common[0]}"
    return base, (Finding("note", what, shown),)


TIMEOUT = 60.0  # time limit of the reader [s]


def read_isolated(path: str, data: bytes, module: str, title: str) -> list[Signal] | str:
    """Return the signals of a file with these data, or its table as text.

    ``module`` is the path of the module whose ``contents`` reads it; path and title of the format
    are for messages. Raises RecordingError when the file is damaged, takes too long or too much
    memory.
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
                arrays = {k: found[f"arr_{k}"] for k in range(len(found.files) - 1)}
                return [
                    Signal(name, arrays.get(place), unit, arrays.get(time), instead=instead)
                    for name, unit, place, instead, time in described
                ]
        except subprocess.TimeoutExpired:
            reason = f"not read within {TIMEOUT:g} s"
        except (ValueError, OSError, KeyError, EOFError, zipfile.BadZipFile):
            last = errors.decode("utf-8", "replace").strip().splitlines()[-1:]
            reason = last[0][:80] if last else f"its reader ended with {process.returncode}"
    raise RecordingError(f"{path}: cannot be read as {title}, perhaps it is damaged ({reason})")
