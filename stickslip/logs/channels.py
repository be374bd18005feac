"""Columns in SI units."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stickslip.errors import RecordingError, UsageError
from stickslip.logs.description import Description, Product
from stickslip.logs.recording import Finding, Motion
from stickslip.logs.roles import named_quantity, suffix_unit
from stickslip.logs.table import LogTable, clock_seconds, is_clock
from stickslip.logs.units import (
    Unit,
    expected_units,
    motion_of,
    quantities_of,
    quantity_key,
    quantity_of,
    unit_fitting,
    unit_named,
    unit_names,
)
from stickslip.servo.measurement import Array

LARGEST = 1e30  # larger numbers indicate a misread file
_COUNTED = (("position", "number"), ("velocity", "number per time"))
_EPOCHS = ((1e18, "ns"), (1e17, "100 ns"), (1e14, "us"), (1e11, "ms"))
"""Times from which on they count this: any since 1970, 100 ns since 1601."""
FEW = 10  # distinct whole numbers up to which a column is a command in levels, and not counts


@dataclass(frozen=True)
class Channel:
    """A column of a log in its role: SI value = unit * scale * logged value + offset."""

    role: str  # one of ``ROLES``
    source: str  # name of the column
    unit: Unit | None  # that of the description, else that of the header; None where none is stated
    scale: Product | None = None  # SI units per unit; None where nothing states it
    offset: Product = 0.0  # in SI units

    @classmethod
    def of(cls, table: LogTable, description: Description, role: str, source: str) -> "Channel":
        """Return the channel of a column."""
        given, unit = description.column(role), unit_of(table, description, role, source)
        scale = _implied_scale(description, role, unit) if given.scale is None else given.scale
        return cls(role, source, unit, scale, offset=given.offset)


def unit_of(table: LogTable, description: Description, role: str, name: str) -> Unit | None:
    """Return the unit of a column: that of the description, else that of the header, else None."""
    given = description.column(role).unit
    if given is not None:
        return unit_named(given)
    fits = quantities_of(role)
    if stated := table.units.get(name):
        return unit_fitting(stated, fits)
    unit = unit_fitting(suffix_unit(name) or "", fits)
    if unit is None and role == "time":
        t = table.numbers.get(name)
        usual = float(np.nanmedian(t)) if t is not None and np.isfinite(t).any() else 0.0
        return next((unit_named(since) for least, since in _EPOCHS if usual > least), None)
    fits |= {"number", "number per time"}
    fits |= {"current", "voltage"} if quantity_key(role) == "force" else set()
    return unit if unit and unit.quantity in fits else None


def unit_fault(
    table: LogTable, description: Description, channel: Channel, motion: Motion
) -> Finding | None:
    """Return the error of a column whose unit is unknown, does not fit its role, or is missing.

    A column needs a unit or a scale if its name is that of another quantity, such as a current, and
    if it holds whole numbers only, as counts and per mille do.
    """
    if channel.scale is not None:
        return None
    role, name, unit = channel.role, channel.source, channel.unit
    expected = quantity_of(role, motion)
    SI = unit_names(expected)[0]
    if unit:
        if unit.quantity == expected:
            return None
        base = unit.name if unit.factor == 1 else unit_names(unit.quantity)[0]
        one = "100 %" if unit.name in ("%", "‰") else f"one {base}"
        if unit.name in ("%", "‰") and quantity_key(role) == "force":
            advice = f"give <rated_{expected} VALUE> or <scale {role}=VALUE>, 100 % in {SI}"
            what = f"{role} is in {unit.name} of a rated {expected} that is not known"
            return Finding("error", what, "", advice)
        what = f"{role} is in {unit.name}, which is no {expected} ({motion} motion)"
        advice = f"give a unit such as {expected_units(role, motion)}, or what {one} is in {SI}"
        advice = f"{advice} with <scale {role}=NUMBER>"
        if (quantity_key(role), unit.quantity) in _COUNTED and unit.name not in ("%", "‰"):
            turn = " (360 deg divided by the counts per turn)" if motion == "rotary" else ""
            advice = f"give <encoder_step>, the size of one count{turn}, or {advice[5:]}"
        if role not in ("time", "position", "force"):
            advice = f"{advice}; <column {role}=none> leaves it out"
        return Finding("error", what, "", advice)
    named = named_quantity(name)
    elsewhere = () if quantity_key(role) == "force" else ("current", "voltage", "torque", "angle")
    if stated := table.units.get(name):
        what = f"unit '{stated}' is unknown"
    elif named not in (None, expected, *elsewhere):
        what = f"a {named} by its name, without a unit"
    elif quantity_key(role) == "force" and description.rated is not None:
        what = f"a rated {expected} is given, but no unit"
        return Finding("error", f"{role}: column '{name}'", what, f"give <unit {role}=%> or 0.1%")
    elif _whole(table.numbers.get(name)):
        what = "whole numbers only, without a unit"
    else:
        return None
    advice = f"give <unit {role}=UNIT>, such as {expected_units(role, motion)}"
    per = {"current": "A", "voltage": "V", "percentage": "1 %", "torque": "N.m"}.get(named or "")
    other = ", or <motion rotary>" if named == "torque" else ""
    advice = f"{advice}, or <scale {role}=NUMBER>, in {SI} per {per or '1'}{other}"
    return Finding("error", f"{role}: column '{name}'", what, advice)


def _implied_scale(description: Description, role: str, unit: Unit | None) -> Product | None:
    """Return what a count or 100 % stands for, where step or rated force tell; else None."""
    key, name = quantity_key(role), unit.name if unit else ""
    if unit and name not in ("%", "‰") and (key, unit.quantity) in _COUNTED:
        return description.encoder_step
    return description.rated if key == "force" and name in ("%", "‰") else None


def _whole(numbers: Array | None) -> bool:
    """Whether numbers (n,) look like raw values of a drive, such as counts or per mille."""
    if numbers is None:
        return False
    known = numbers[np.isfinite(numbers)]
    return bool(np.all(known == np.round(known))) and len(np.unique(known)) > FEW


def motion_from(
    description: Description, channels: Sequence[Channel]
) -> tuple[Motion, list[Finding]]:
    """Return the motion: that of the description, else of a unit, else of the position's name."""
    if description.motion:
        return description.motion, []
    for one in channels:
        if one.unit and one.scale is None and (motion := motion_of(one.unit)):
            figure = f"{one.role} in {one.unit.name}"
            return motion, [Finding("note", f"motion is taken for {motion}", figure)]
    for one in channels:
        if one.role == "position" and named_quantity(one.source) == "angle":
            figure = f"position is column '{one.source}'"
            return "rotary", [Finding("note", "motion is taken for rotary", figure)]
    return "linear", []


def signal_of(table: LogTable, channel: Channel) -> Array:
    """Return a column (n,) in SI units.

    A unit that does not fit the role needs a scale, see ``unit_fault``. Raises UsageError when the
    scale is 0, or RecordingError when the column holds no numbers, or larger ones than any drive
    has.
    """
    role, name = channel.role, channel.source
    scale = table.value(1.0 if channel.scale is None else channel.scale, f"scale of {role}")
    offset = table.value(channel.offset, f"offset of {role}")
    factor = scale * (channel.unit.factor if channel.unit else 1.0)
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
            f"{table.path}: column '{name}', row {row}: {signal[absurd[0]]:.3g} is too large; "
            "check delimiter, decimal sign and scale"
        )
    return signal


UNSTATED = "columns that state no unit"


def assumed_units(channels: Sequence[Channel], motion: Motion) -> list[Finding]:
    """Return the note on columns without a stated unit."""
    assumed = [
        f"{one.role} in {unit_names(quantity_of(one.role, motion))[0]}"
        for one in channels
        if one.unit is None and one.scale is None
    ]
    figure, advice = "taken for " + ", ".join(assumed), "<unit ROLE=UNIT> states another"
    return [Finding("note", UNSTATED, figure, advice)] if assumed else []


def _points_in_time(table: LogTable, name: str) -> Array:
    """Return seconds (n,) since the first of points in time such as 2026-01-31T10:00:00.125."""
    texts = table.texts[name]
    if not is_clock(texts[0]):
        table.column(name)  # raises and names the row
    try:
        return clock_seconds(texts)
    except (ValueError, OverflowError) as error:
        reason = " ".join(str(error).split())[:80]
        raise RecordingError(f"{table.path}: column '{name}': not a time ({reason})") from None
