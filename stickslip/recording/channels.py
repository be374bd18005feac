"""Columns in SI units."""

from __future__ import annotations

import math
import re

import numpy as np
import pandas as pd

from stickslip.errors import RecordingError, UsageError
from stickslip.measurement import Array
from stickslip.recording.description import Description, quantity_key
from stickslip.recording.finding import Finding
from stickslip.recording.products import value_of
from stickslip.recording.recording import Motion
from stickslip.recording.roles import suffix_unit
from stickslip.recording.table import LogTable
from stickslip.recording.units import QUANTITIES, Unit, motion_of, unit_named, unit_names

LARGEST = 1e30
"""Numbers beyond are taken for a file that was misread."""


def unit_of(table: LogTable, description: Description, role: str, name: str) -> Unit | None:
    """Return the unit of a column: as its owner says, else as the header says, else None.

    Raises
    ------
    UsageError
        When the owner names a unit that does not exist.
    RecordingError
        When the header does.
    """
    said = description.column(role).unit
    if said is not None:
        if unit := unit_named(said):
            return unit
        raise UsageError(f"unit '{said}' of {role} is unknown; expected {_expected(role)}")
    if stated := table.units.get(name):
        if unit := unit_named(stated):
            return unit
        raise RecordingError(
            f"{table.path}: column '{name}': unit '{stated}' is unknown; say --unit {role}=UNIT, "
            f"such as {_expected(role)}"
        )
    ending = suffix_unit(name)
    unit = unit_named(ending) if ending else None
    fits = {"time"} if role == "time" else {q[quantity_key(role)] for q in QUANTITIES.values()}
    electric = quantity_key(role) == "force" and unit and unit.quantity in ("current", "voltage")
    return unit if unit and (unit.quantity in fits or electric) else None


def motion_from(
    description: Description, units: dict[str, Unit | None]
) -> tuple[Motion, list[Finding]]:
    """Return the motion: as its owner says, else as the first unit says, else linear."""
    if description.motion:
        return description.motion, []
    for role, unit in units.items():
        motion = motion_of(unit) if unit and description.column(role).scale is None else None
        if motion:
            said = unit.name if unit else ""
            return motion, [Finding("note", f"motion is taken for {motion}", f"{role} in {said}")]
    return "linear", []


def signal_of(
    table: LogTable,
    description: Description,
    role: str,
    name: str,
    unit: Unit | None,
    motion: Motion,
) -> Array:
    """Return a column (n,) in SI units.

    Raises
    ------
    UsageError
        When a unit does not suit the role and no scale tells what it means.
    """
    column = description.column(role)
    expected = _quantity(role, motion)
    scale = value_of(
        1.0 if column.scale is None else column.scale, table.scalars, f"scale of {role}"
    )
    offset = value_of(column.offset, table.scalars, f"offset of {role}")
    if unit is None:
        factor = scale
    elif unit.quantity == expected or column.scale is not None:
        factor = unit.factor * scale
    elif unit.name in _COUNTS and quantity_key(role) == "position" and description.encoder_step:
        factor = value_of(description.encoder_step, table.scalars, "encoder_step")
    else:
        SI = unit_names(expected)[0]
        raise UsageError(
            f"{role} is in {unit.name}, which is no {expected} ({motion} motion); give a unit "
            f"such as {_expected(role, motion)}, or what one {unit.name} is in {SI} with --scale"
        )
    if not (math.isfinite(factor) and factor != 0):
        raise UsageError(f"scale of {role} = {factor:g}: expected a number other than 0")
    if role == "time" and name in table.texts:
        return _points_in_time(table, name)
    with np.errstate(over="ignore", invalid="ignore"):
        signal = np.asarray(table.column(name) * factor + offset)
        absurd = np.flatnonzero(np.isfinite(signal) & (np.abs(signal) > LARGEST))
    if absurd.size:
        row = table.row(int(absurd[0]))
        raise RecordingError(
            f"{table.path}: column '{name}', row {row}: no drive shows {signal[absurd[0]]:.3g}; "
            "check delimiter, decimal sign and scale"
        )
    return signal


_COUNTS = ("counts", "count", "cts", "inc", "increments", "1")


def assumed_units(
    description: Description, units: dict[str, Unit | None], motion: Motion
) -> list[Finding]:
    """Return the remark on columns whose unit nobody states."""
    assumed = [
        f"{role} in {unit_names(_quantity(role, motion))[0]}"
        for role, unit in units.items()
        if unit is None and description.column(role).scale is None
    ]
    if not assumed:
        return []
    advice = "--unit ROLE=UNIT says otherwise"
    return [
        Finding("note", "columns that state no unit", "taken for " + ", ".join(assumed), advice)
    ]


def _points_in_time(table: LogTable, name: str) -> Array:
    """Return seconds (n,) since the first of points in time such as 2026-01-31T10:00:00.125."""
    texts = table.texts[name]
    if not all(re.match(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d", text) for text in texts[:1]):
        table.column(name)  # says which row
    try:
        times = pd.to_datetime(list(texts), format="ISO8601", utc=True)
    except (ValueError, OverflowError) as error:
        said = " ".join(str(error).split())[:80]
        raise RecordingError(f"{table.path}: column '{name}': no point in time ({said})") from None
    return np.asarray((times - times[0]).total_seconds(), dtype=np.float64)


def _quantity(role: str, motion: Motion) -> str:
    return "time" if role == "time" else QUANTITIES[motion][quantity_key(role)]


def _expected(role: str, motion: Motion | None = None) -> str:
    """Return the commonest units of a role."""
    motions = [motion] if motion else list(QUANTITIES)
    names = [name for m in motions for name in unit_names(_quantity(role, m))[:4]]
    return ", ".join(dict.fromkeys(names))
