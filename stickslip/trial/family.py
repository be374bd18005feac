"""The drives that a log supports, and a run of one of them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from stickslip import cosim
from stickslip.catalog.parameters import ParameterSpace, friction_law, start_unit
from stickslip.cosim import Trapezoid
from stickslip.identification.criteria.runs import require_bounded
from stickslip.models import Law
from stickslip.models.export.units import motion_unit
from stickslip.servo.axis import Datasheet
from stickslip.servo.measurement import Array
from stickslip.servo.systems import Feed, paper_loop
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.storage.codec import entry
from stickslip.thresholds import harm


@dataclass(frozen=True)
class Trial:
    """What is tried; the axis is a drive FMU with the mass and lag that the loop counts on."""

    fmus: Path  # folder of the FMUs, as ``build_fmus`` leaves it
    loop: VelocityLoop  # the velocity loop
    friction: Mapping[str, float]  # of the axis, parameters of ``law`` by name
    compensator: Mapping[str, float]  # its parameters by name
    v_cmd: Array  # command (n,) [m/s], one value a sample of the loop
    feed: Feed = "nominal"
    datasheet: Datasheet = field(default_factory=Datasheet)
    law: Law = field(default_factory=friction_law)  # friction law of axis and compensator

    @contextmanager
    def runs(self, *, compensated: bool) -> Iterator[Run]:
        """Prepare runs with or without the compensator."""
        chosen = dict(self.compensator) if compensated else None
        system = paper_loop(self.fmus, self.loop, chosen, self.feed)
        axis = {**self.friction, **axis_values(self.loop, self.datasheet)}
        system.parameters |= in_loop(axis)
        stop = (len(self.v_cmd) - 1) * self.loop.T_s
        with system.prepare(step=self.loop.T_s, stop=stop, record=("drive.v",)) as simulation:
            yield Run(self, simulation)


def axis_values(loop: VelocityLoop, sheet: Datasheet) -> dict[str, float | bool]:
    """Return the start values of a drive FMU on the axis that a loop counts on."""
    known = {**loop.axis.of_drive(), "u_max": sheet.peak_force}
    # The paper's converter has steps larger than the friction of a small drive.
    return {**known, "dac": False, "encoder_step": sheet.encoder_step}


def in_loop(drive: Mapping[str, float]) -> dict[str, float]:
    """Return start values of a drive FMU as those of a loop, whose controller has its limit."""
    values = {f"drive.{name}": value for name, value in drive.items()}
    return {**values, "controller.u_max": drive["u_max"]}


@dataclass(frozen=True)
class Run:
    """A prepared loop."""

    trial: Trial
    simulation: cosim.Simulation

    def velocity(self, compensator: Mapping[str, float] | None = None) -> Array:
        """Return the velocity (n,) [m/s], with other parameters of the compensator than its own."""
        values = {f"compensator.{name}": value for name, value in (compensator or {}).items()}
        commands = self.trial.loop.commands(self.trial.v_cmd)
        return self.simulation.run(values, commands)["drive.v"]

    def error(self, compensator: Mapping[str, float] | None = None) -> float:
        """Return the RMS of v - v_cmd [m/s]; infinite when the run fails or the loop runs away.

        In a cascade, which may lag behind its command, it is that to the motion without friction.
        """
        loop, target = self.trial.loop, self.trial.v_cmd
        if loop.K_x:
            target, _ = loop.response(target)
        try:
            v = self.velocity(compensator)
            require_bounded(v, float(np.max(np.abs(self.trial.v_cmd))))
        except cosim.SimulationError:
            return np.inf
        return float(np.sqrt(np.mean((v - target) ** 2)))


@dataclass(frozen=True)
class Finding:
    """One warning."""

    guard: str  # name of the guard
    figure: float  # what was found, in ``unit``
    limit: float  # the largest acceptable value
    unit: str
    message: str  # what, figure, limit and what to do, in a line

    def __str__(self) -> str:
        return f"{self.guard}: {self.message}"


Values = Mapping[str, float]

SPEEDS = (1.0, 0.1, 0.01)  # shares of the log's speed
MOVES = {"micro-steps": (3.0, 20.0, 0.01), "short moves": (30.0, 200.0, 0.1)}
"""Lengths of small moves: in presliding deflections, at least in encoder steps, and at most as a
share of the travel."""
LEVELS = (0.5, 1.5)  # shares of the fitted friction
UNEVEN = 0.1  # share by which friction differs by direction, and along the guide
PERIOD = 0.4  # length of its variation along the guide, as a share of the travel
_REST = 0.1  # pause between moves [s]
_LEAST = 20  # samples in a move
_DEFLECTION = 4e-4  # presliding deflection over the command's speed where no stiffness is known [s]


@dataclass(frozen=True)
class Drive:
    """A drive of the family."""

    name: str = field(metadata=entry(key="drive"))  # how it differs from the fitted one
    law: str  # name of its friction law
    parameters: Values = field(metadata=entry(start_unit))  # of the drive FMU


@dataclass(frozen=True, eq=False)
class Command:
    """A command on which drives are tried.

    Attributes
    ----------
    name : display name
    v_cmd : (n,) one value a sample [m/s]
    """

    name: str
    v_cmd: Array

    @property
    def speed(self) -> float:
        """Largest speed [m/s]."""
        return float(np.max(np.abs(self.v_cmd)))


@dataclass(frozen=True)
class Evidence:
    """What a log tells of a drive's friction besides the values that a compensator takes."""

    plausible: Sequence[Values] = ()  # that the log supports: the fit first, then draws from it
    # interval by name for parameters that are poorly identified
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    # values by name for other laws fitted to the same log, by name of the law
    rivals: Mapping[str, Values] = field(default_factory=dict)
    better: frozenset[str] = frozenset()  # laws that predict better than the compensator's


def family(
    law: Law, friction: Values, command: Trapezoid, known: Evidence, *, rotary: bool = False
) -> tuple[Drive, ...]:
    """Return the drives on which a compensator is tried.

    Friction is given by parameters of the law, as the compensator takes them. The command is the
    fastest one, whose travel gives the period of friction along the guide.
    """
    uneven = {
        f"friction {100 * UNEVEN:g} % higher in one direction": {
            "asymmetric": True,
            "asymmetry": UNEVEN,
        },
        f"friction +-{100 * UNEVEN:g} % along the guide": {
            "position_dependent": True,
            "position_amplitude": UNEVEN,
            "position_period": PERIOD * travel(command),
        },
    }
    own = {
        "friction as fitted": friction,
        **{f"friction x {level:g}": law.share(friction, level) for level in LEVELS},
        **{name: {**friction, **changes} for name, changes in uneven.items()},
        **dict(_corners(law, friction, known.ranges, rotary=rotary)),
        **{f"plausible friction {k + 1}": one for k, one in enumerate(known.plausible)},
    }
    drives = [Drive(name, law.name, values) for name, values in own.items()]
    for other, values in known.rivals.items():
        rival = friction_law(other)
        name = f"{rival.title} friction"
        drives.append(Drive(name, other, values))
        if other in known.better:
            more = _more_at_rest(rival, values, SPEEDS[-1] * command.height)
            drives += [Drive(f"{name}, more at rest", other, more)] if more != values else []
    return tuple(drives)


def commands(
    command: Trapezoid,  # the trapezoid at full speed
    T_s: float,
    friction: Values,  # gives the presliding deflection, in which small moves are measured
    encoder_step: float = 0.0,  # of which a move has several [m]
    *,
    rotary: bool = False,
) -> tuple[Command, ...]:
    """Return the commands: a trapezoid at the speeds of ``SPEEDS``, and small moves."""
    unit = motion_unit("mm/s", rotary=rotary)
    t = np.arange(round((command.corners()[-1] + command.begin) / T_s) + 1) * T_s
    found = []
    for share in SPEEDS:
        slower = replace(command, height=share * command.height, slope=share * command.slope)
        found.append(Command(f"{1e3 * slower.height:.3g} {unit}", slower.sample(t)))
    for name, (deflections, steps, share) in MOVES.items():
        length = max(deflections * deflection(friction, command), steps * encoder_step)
        length = min(length, share * travel(command))
        found.append(Command(name, _moves(length, command, T_s)))
    return tuple(found)


def travel(command: Trapezoid) -> float:
    """Return how far a trapezoid moves in one direction [m]."""
    return abs(command.height) * (command.plateau + abs(command.height) / command.slope)


def deflection(friction: Values, command: Trapezoid) -> float:
    """Return the presliding deflection F_c / sigma_0 [m], or one typical of the speed."""
    if "sigma_0" in friction:
        return friction["F_c"] / friction["sigma_0"]
    return _DEFLECTION * abs(command.height)


def _more_at_rest(law: Law, values: Values, slow: float) -> Values:
    """Return friction with a higher rise towards rest, which begins at a slow speed [m/s] at least.

    Where the log has little slow motion, a fit puts the rise below the speeds that it has.
    """
    higher = {name: harm.RESERVE * values[name] for name in ParameterSpace.of(law).bounded}
    speeds = [one.name for one in law.parameters.values() if one.shown_by and one.unit == "m/s"]
    return {**values, **higher, **{name: max(values[name], slow) for name in speeds}}


def _corners(
    law: Law, friction: Values, ranges: Mapping[str, tuple[float, float]], *, rotary: bool
) -> Iterator[tuple[str, Values]]:
    """Yield friction without rise towards rest, and with each value at either end."""
    bounded = ParameterSpace.of(law).bounded
    for name, bound in bounded.items():
        yield f"{name} = {bound}", {**friction, name: friction[bound]}
    for name, ends in ranges.items():
        unit = motion_unit(law.parameters[name].unit, rotary=rotary)
        for value in ends:
            changed = {**friction, name: value}
            changed |= {one: max(changed[one], changed[bound]) for one, bound in bounded.items()}
            yield f"{name} = {value:.3g} {unit}", changed


def _moves(length: float, command: Trapezoid, T_s: float) -> Array:
    """Return smooth moves forward and backward, three each, with the command's acceleration."""
    duration = max(
        math.sqrt(2.0 * math.pi * length / command.slope),
        2.0 * length / abs(command.height),
        _LEAST * T_s,
    )
    n = math.ceil(duration / T_s)
    move = length / (n * T_s) * (1.0 - np.cos(2.0 * np.pi * np.arange(n) / n))
    rest = np.zeros(math.ceil(_REST / T_s))
    both = np.concatenate([move, rest, -move, rest])
    return np.concatenate([rest, *3 * [both]])
