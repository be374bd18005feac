"""A rig described by a TOML file: where the drive is, its datasheet, limits, and the experiment."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Sequence
from dataclasses import fields
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from stickslip.errors import UsageError
from stickslip.planning import Limits
from stickslip.rigs.contract import Rig
from stickslip.rigs.limits import RigLimits
from stickslip.servo.axis import Datasheet
from stickslip.toml_files import NUMBER, PAIR, TABLE, TEXT, WHOLE, Kind, checked, read_toml

KINDS: dict[type, Kind] = {float: NUMBER, int: WHOLE, str: TEXT, type(None): TEXT}
"""What a key of the file has to be, by the type of the argument's default."""
PAIRS = ("travel", "frequency", "slow", "presliding")


def open_rig(path: Path | str, law: str = "lugre") -> tuple[Rig, Limits]:
    """Connect to the rig that a TOML file describes; return it with the limits of experiments.

    One key names the kind of rig, an entry point of the group ``stickslip.rigs``, and its value
    says where the drive is, such as ``socket = "HOST:PORT"`` or ``ads = "NETID"``. Other keys are
    keyword arguments of that class; the sections are ``[datasheet]``, ``[limits]`` (``RigLimits``)
    and ``[experiment]`` (``Limits``). All values are in SI units.

    Parameters
    ----------
    law : friction law of the compensator

    Raises
    ------
    UsageError
        When the file cannot be read, no such kind of rig is installed, or a key is missing, unknown
        or has a wrong value.
    RigError
        When nobody answers.
    """
    path = Path(path)
    content = read_toml(path)
    try:
        sheet = Datasheet(
            **_section(content, "datasheet", Datasheet, ("mass", "peak_force", "encoder_step"))
        )
        limits = RigLimits(**_section(content, "limits", RigLimits, _names(RigLimits)))
        experiment = Limits(**_section(content, "experiment", Limits, ()))
        name, rig = _kind(content)
        further = inspect.signature(rig).parameters.values()
        named = {
            one.name: KINDS[type(one.default)] for one in further if one.kind is one.KEYWORD_ONLY
        }
        given = checked(content, {name: TEXT, **named})
    except UsageError as error:
        raise UsageError(f"{path}: {error}") from None
    return rig(given.pop(name), sheet, limits, law, **given), experiment


def _kind(keys: Collection[str]) -> tuple[str, Callable[..., Rig]]:
    """Return the one key that names an installed kind of rig, and the class of that kind."""
    installed = entry_points(group="stickslip.rigs")
    found = [name for name in installed.names if name in keys]
    if len(found) != 1:
        kinds, got = ", ".join(sorted(installed.names)), ", ".join(map(repr, keys)) or "none"
        raise UsageError(
            f"expected one key that names an installed kind of rig ({kinds}); got {got}"
        )
    try:
        return found[0], installed[found[0]].load()
    except (ImportError, AttributeError) as fault:
        raise UsageError(f"{installed[found[0]].value} cannot be imported ({fault})") from None


def _names(kind: type) -> list[str]:
    return [field.name for field in fields(kind)]


def _section(
    content: dict[str, Any], name: str, kind: type, needed: Sequence[str]
) -> dict[str, Any]:
    """Take a section out of the file; return its values by name."""
    table: dict[str, Any] = checked({name: content.pop(name, {})}, {name: TABLE})[name]
    kinds = {one: PAIR if one in PAIRS else NUMBER for one in _names(kind)}
    for one in needed:
        if one not in table:
            raise UsageError(f"{name}.{one} is missing; expected {kinds[one][1]}, in SI units")
    return checked(table, kinds, f"{name}.")
