"""A rig described by a TOML file: where the drive is, its datasheet, limits, and the experiment."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

from stickslip.errors import UsageError
from stickslip.planning import Limits
from stickslip.rigs.ads_rig import AdsRig
from stickslip.rigs.limits import RigLimits
from stickslip.rigs.remote import RemoteRig
from stickslip.rigs.socket_rig import SocketRig
from stickslip.servo.datasheet import Datasheet
from stickslip.toml_files import NUMBER, PAIR, TABLE, TEXT, WHOLE, Kind, checked, read_toml

KINDS: dict[str, tuple[Callable[..., RemoteRig], dict[str, Kind]]] = {
    "socket": (SocketRig, {"patience": NUMBER, "retry": NUMBER}),
    "ads": (AdsRig, {"port": WHOLE, "symbol": TEXT, "ip": TEXT, "patience": NUMBER}),
}
"""Keys that say where the drive is, with the kind of rig, and its further arguments."""
PAIRS = ("travel", "frequency", "slow", "presliding")


def open_rig(path: Path | str, law: str = "lugre") -> tuple[RemoteRig, Limits]:
    """Connect to the rig that a TOML file describes; return it with the limits of experiments.

    The file has ``socket = "HOST:PORT"`` or ``ads = "NETID"``, further arguments of ``SocketRig``
    or ``AdsRig`` by name, and the sections ``[datasheet]``, ``[limits]`` (``RigLimits``) and
    ``[experiment]`` (``Limits``). All values are in SI units.

    Parameters
    ----------
    law : friction law of the compensator

    Raises
    ------
    UsageError
        When the file cannot be read, or a key is missing, unknown or has a wrong value.
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
        where = _place(content)
        kind, further = KINDS[where]
        given = checked(content, {where: TEXT, **further})
    except UsageError as error:
        raise UsageError(f"{path}: {error}") from None
    return kind(given.pop(where), sheet, limits, law, **given), experiment


def _place(content: Collection[str]) -> str:
    """Return the one key that says where the drive is."""
    found = [name for name in KINDS if name in content]
    if len(found) != 1:
        raise UsageError('expected socket = "HOST:PORT" or ads = "NETID"')
    return found[0]


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
