"""What learned.json knows beside the parameters: their errors, the loop, how it was validated.

    "loop": {"K_p": {"value": 4717.4, "unit": "N.s/m"}, ...}     absent in older files
    "validation": {"height": {"value": 0.04, "unit": "m/s"}, ...}
    "datasheet": {"encoder_step": {"value": 4e-7, "unit": "m"}, ...}

The loop is m b tau_i T_s tau_f K_p K_i, and where they are used m_ff and the gains L_x L_v L_d of a
velocity filter.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import numpy as np

from stickslip import cosim
from stickslip.catalog.parameters import LUGRE
from stickslip.errors import UsageError
from stickslip.fmi.files import MOST_TEXT, parse_json, read_limited
from stickslip.servo.axis import Axis, ControlError
from stickslip.servo.datasheet import VALIDATION, Datasheet
from stickslip.servo.systems import FEEDS, Feed
from stickslip.servo.velocity_filter import VelocityFilter
from stickslip.servo.velocity_loop import VelocityLoop, close_velocity_loop

UNITS = {
    "m": "kg",
    "b": "N.s/m",
    "tau_i": "s",
    "T_s": "s",
    "tau_f": "s",
    "K_p": "N.s/m",
    "K_i": "N/m",
    "m_ff": "kg",
    "L_x": "1",
    "L_v": "1/s",
    "L_d": "N/m",
}
DATASHEET = {"peak_force": "N", "tau_i": "s", "encoder_step": "m"}
TRAPEZOID = {"height": "m/s", "slope": "m/s2", "plateau": "s", "begin": "s"}
_GAINS = ("L_x", "L_v", "L_d")
_AXIS = ("m", "b", "tau_i")
_LOOP = ("T_s", "tau_f", "K_p", "K_i")


def loop_document(loop: VelocityLoop) -> dict[str, dict[str, Any]]:
    """Return a velocity loop as plain data, for the entry ``loop``."""
    values = {name: getattr(loop.axis, name) for name in _AXIS}
    values |= {name: getattr(loop, name) for name in (*_LOOP, "m_ff")}
    if loop.velocity_filter is not None:
        values |= {name: getattr(loop.velocity_filter, name) for name in _GAINS}
    return {name: {"value": value, "unit": UNITS[name]} for name, value in values.items()}


def validation_document(command: cosim.Trapezoid) -> dict[str, dict[str, Any]]:
    """Return a validation command as plain data, for the entry ``validation``."""
    values = dataclasses.asdict(command)
    return {name: {"value": values[name], "unit": unit} for name, unit in TRAPEZOID.items()}


def datasheet_document(sheet: Datasheet) -> dict[str, dict[str, Any]]:
    """Return what is known of motor and encoder as plain data, for the entry ``datasheet``."""
    return {name: {"value": getattr(sheet, name), "unit": DATASHEET[name]} for name in DATASHEET}


def read_document(path: Path) -> dict[str, Any]:
    """Return the content of a learned.json, of which nothing is known but that it is an object.

    Raises
    ------
    UsageError
        When it is no JSON, or something else than an object.
    OSError
        When it cannot be read.
    """
    try:
        document = parse_json(read_limited(path, MOST_TEXT))
    except ValueError as error:
        raise UsageError(f"{path}: not a learned.json: {error}") from None
    if not isinstance(document, dict):
        raise UsageError(
            f"{path}: not a learned.json: it has another structure; expected parameters "
            f"{', '.join(LUGRE)}, each with a value"
        )
    return document


def read_loop(path: Path) -> VelocityLoop | None:
    """Return the loop of a learned.json; None when it tells of none.

    Raises
    ------
    UsageError
        When the entry lacks something, or the loop is none.
    """
    entry = _entry(path, "loop")
    if entry is None:
        return None
    try:
        with np.errstate(all="ignore"):
            return _loop_of(entry)
    except KeyError as error:
        raise UsageError(
            f"{path}: loop: {error} is missing; expected {', '.join((*_AXIS, *_LOOP))}"
        ) from None
    except ControlError as error:
        raise UsageError(f"{path}: loop: {error}") from None
    except (ValueError, ArithmeticError) as error:  # numbers with which nothing can be computed
        told = ", ".join(f"{name} = {value:g}" for name, value in entry.items())
        raise UsageError(f"{path}: loop: {told} make no loop ({error})") from None


def _loop_of(entry: Mapping[str, float]) -> VelocityLoop:
    axis = Axis(**{name: entry[name] for name in _AXIS})
    velocity_filter = None
    if "L_x" in entry:
        gains = {name: entry[name] for name in _GAINS}
        velocity_filter = VelocityFilter(axis, entry["T_s"], **gains)
    return close_velocity_loop(
        axis,
        **{name: entry[name] for name in _LOOP},
        m_ff=entry.get("m_ff", 0.0),
        velocity_filter=velocity_filter,
    )


def read_validation(path: Path) -> cosim.Trapezoid:
    """Return the validation command of a learned.json, the paper's when it tells of none.

    Raises
    ------
    UsageError
        When the entry lacks something.
    """
    entry = _entry(path, "validation")
    if entry is None:
        return VALIDATION
    if set(entry) != set(TRAPEZOID) or not entry["slope"] > 0.0 or not entry["height"]:
        raise UsageError(
            f"{path}: validation: expected {', '.join(TRAPEZOID)}, slope above 0, height not 0;"
            f" got {entry}"
        )
    return cosim.Trapezoid(**entry)


def read_datasheet(path: Path) -> Datasheet:
    """Return what a learned.json tells of motor and encoder, the paper's when it tells nothing.

    Raises
    ------
    UsageError
        When the entry names something else, or a value is not above 0.
    """
    entry = _entry(path, "datasheet") or {}
    if not set(entry) <= set(DATASHEET) or not all(
        value > 0.0 or (name == "tau_i" and value == 0.0) for name, value in entry.items()
    ):
        raise UsageError(
            f"{path}: datasheet: expected {', '.join(DATASHEET)}, each above 0; got {entry}"
        )
    return Datasheet(**entry)


def read_standard_errors(path: Path) -> dict[str, float]:
    """Return the standard errors of a learned.json by parameter, those that it tells, in SI."""
    parameters = read_document(path)["parameters"]
    told = {name: parameters[name].get("standard_error") for name in LUGRE}
    return {
        name: float(value)
        for name, value in told.items()
        if isinstance(value, (int, float)) and math.isfinite(value) and value > 0.0
    }


def read_feed(path: Path) -> Feed:
    """Return what drives the compensator of a learned.json, the nominal loop when it tells nothing.

    Raises
    ------
    UsageError
        When it tells of something else than is known.
    """
    feed = read_document(path).get("feed", "nominal")
    if feed not in FEEDS:
        raise UsageError(f"{path}: feed is {feed!r}; expected {' or '.join(FEEDS)}")
    return cast(Feed, feed)


def _entry(path: Path, name: str) -> dict[str, float] | None:
    """Return the values of an entry, None when there is none."""
    entry = read_document(path).get(name)
    if entry is None:
        return None
    try:
        return {key: _number(item) for key, item in entry.items()}
    except (AttributeError, KeyError, TypeError, ValueError):
        raise UsageError(
            f"{path}: {name}: expected names, each with a value and a unit; got {entry!r:.80}"
        ) from None


def _number(item: Mapping[str, Any]) -> float:
    value = float(item["value"])
    if not math.isfinite(value):
        raise ValueError(value)
    return value
