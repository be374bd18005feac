"""The parameters of a drive: those of its friction law, from ``law.toml``, and its own."""

from __future__ import annotations

from functools import cache

from stickslip import models
from stickslip.models import Law, LawParameter
from stickslip.models.export.units import force_and_length, motion_unit


def _drive(name: str, unit: str, symbol: str, meaning: str, shown_by: str | None) -> LawParameter:
    force, length = force_and_length(unit)
    return LawParameter(
        name=name,
        unit=unit,
        description=meaning,
        start=(0.0,),
        low=float("-inf"),
        high=float("inf"),
        display=None,
        symbol=symbol,
        coordinate="log" if name == "m" else "linear",
        at_least=None,
        spread=None,
        shown_by=shown_by,
        requires=None,
        weakest="low",
        choices=(),
        force=force,
        length=length,
    )


DRIVE = {
    parameter.name: parameter
    for parameter in (
        _drive("m", "kg", "$m$", "Inertia", shown_by="quick ramps of velocity"),
        _drive(
            "b", "N.s/m", "$b$", "Viscous friction", shown_by="constant speeds over the whole range"
        ),
        _drive("F_0", "N", "$F_0$", "Constant force against the motor", shown_by=None),
        _drive(
            "delay", "s", "$t_d$", "Delay of the force against its log or command", shown_by=None
        ),
    )
}
"""The parameters that every drive has, whatever its friction law."""

PAPER = {
    "m": 5.557,
    "b": 6.6135,
    "F_s": 8.999,
    "F_c": 5.999,
    "v_s": 0.00055697,
    "sigma_0": 3.9162e5,
    "sigma_1": 4.4248e3,
}
"""Table 2 of the paper. It prints b in Nm/sec, which must read N s/m."""


@cache
def friction_law(name: str = "lugre") -> Law:
    """Return a friction law of ``models/laws``, LuGre by default.

    Raises models.UnknownLaw when there is no such law.
    """
    return models.load_law(name)


def estimated(law: Law) -> tuple[str, ...]:
    """Return the names of a law's parameters that an experiment shows, in the order of law.toml."""
    return tuple(name for name, parameter in law.parameters.items() if parameter.shown_by)


def learnable_laws() -> list[str]:
    """Return the names of the laws with parameters that an experiment shows."""
    return [name for name in models.law_names() if estimated(friction_law(name))]


def tabulated(law: Law) -> tuple[str, ...]:
    """Return the names of a table of identified parameters: m, b and those of the law."""
    return ("m", "b", *estimated(law))


def presliding(law: Law) -> tuple[str, ...]:
    """Return the names of a law's parameters that moves below break-away show."""
    moves = ("presliding moves", "quick presliding moves")
    return tuple(name for name, one in law.parameters.items() if one.shown_by in moves)


def scaled_start(one: LawParameter, F_c: float, deflection: float) -> float:
    """Return a start value for a drive with this friction [N] and presliding deflection [m]."""
    force, length = F_c / PAPER["F_c"], deflection / (PAPER["F_c"] / PAPER["sigma_0"])
    return float(one.start[0] * force**one.force * length**one.length)


@cache
def parameter(name: str) -> LawParameter:
    """Return a parameter of a drive or of any friction law.

    Raises KeyError when there is none of this name.
    """
    if name in DRIVE:
        return DRIVE[name]
    for law in map(friction_law, ("lugre", *models.law_names())):
        if name in law.parameters:
            return law.parameters[name]
    raise KeyError(name)


def unit_of(name: str, *, rotary: bool = False) -> str:
    """Return the unit of a parameter, for a linear or a rotary drive."""
    return motion_unit(parameter(name).unit, rotary=rotary)


@cache
def start_unit(name: str, *, rotary: bool = False) -> str:
    """Return the unit of a start value of the drive FMU, of any law."""
    try:
        return unit_of(name, rotary=rotary)
    except KeyError:
        units = {one.name: one.unit for one in models.load_model("drive").variables}
        return motion_unit(units[name] or "1", rotary=rotary)


@cache
def force_and_length_of(name: str) -> tuple[int, int]:
    """Return the powers of the units of force and length in a parameter or controller gain.

    The unit of a gain is the one that the controller's model.toml gives; a value that is not known
    has neither.
    """
    gains = {v.name: v.unit for v in models.load_model("velocity_controller").variables}
    try:
        return parameter(name).force, parameter(name).length
    except KeyError:
        return force_and_length(gains.get(name) or "1")


LUGRE = estimated(friction_law())  # the parameters of the paper's compensator

UNITS = {name: unit_of(name) for name in PAPER}  # units of Table 2
