"""The drives that a log supports, and the commands on which they are tried."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import cycle

import numpy as np

from stickslip.catalog.parameters import friction_law, start_unit
from stickslip.cosim import Trapezoid
from stickslip.models import Law
from stickslip.models.export.units import motion_unit
from stickslip.servo.axis import Datasheet
from stickslip.servo.measurement import Array
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.storage.codec import entry
from stickslip.thresholds import harm


def axis_values(loop: VelocityLoop, sheet: Datasheet) -> dict[str, float | bool]:
    """Return the start values of a drive FMU on the axis that a loop counts on."""
    known = {**loop.axis.of_drive(), "u_max": sheet.peak_force}
    # The paper's converter has steps larger than the friction of a small drive.
    return {**known, "dac": False, "encoder_step": sheet.encoder_step}


def in_loop(drive: Mapping[str, float]) -> dict[str, float]:
    """Return start values of a drive FMU as those of a loop, whose controller has its limit."""
    values = {f"drive.{name}": value for name, value in drive.items()}
    return {**values, "controller.u_max": drive["u_max"]}


Values = Mapping[str, float]

FITTED = "friction as fitted"  # name of the drive with the values that the compensator takes

SPEEDS = (1.0, 0.1)  # shares of the log's speed
CREEP = "creep"
CREEPS = (0.3, 0.15)  # its speeds over the Stribeck velocity
SLOWEST, FASTEST = 0.001, 0.03  # their bounds as shares of the log's speed
CREEPS_OF_LEVEL = (0.001, 0.01)  # the same shares where friction does not rise towards rest
SLIPS = (3.0, 5.0)  # times that an integral needs to break away in creep, and most of them [s]
MICRO = "micro-steps"
MOVES = {MICRO: (4.0, 10.0, 0.01), "short moves": (60.0, 100.0, 0.1)}
"""Lengths of small moves: in presliding deflections of the drive, at least in encoder steps, and at
most as a share of the travel."""
PRESLIDING = ("sigma_0", "sigma_1")  # what does not follow the level of friction, in a drawn drive
SLOW_MOVE = "any slow small move"
SWEEP = ("any small move", "creep at any speed", SLOW_MOVE)
SLOW = 2.0  # least duration of a slow move, over the rise time of the loop
SWEPT_MOVES, SWEPT_CREEPS = 12, (0.08, 0.15, 0.3, 0.6, 1.2)
"""Number of moves in the sweep, and its speeds of creep over the Stribeck velocity."""
TWICE, ALTERNATING = (1, 1, -1, -1, 1, -1), (1, -1, 1, -1, 1, -1)
"""Directions of small moves: a second one the same way begins where friction holds the drive. In
the sweep, whose limit was set so, they alternate (decision 170)."""
LENGTHS = 4  # deflections of drives whose law has none
LONGEST = 3.0  # the largest of them, over that which an encoder shows
BEYOND = (0.5, 2.0)  # levels of friction that decide nothing, and are shown beside the others
UNEVEN = 0.1  # share by which friction differs by direction, and along the guide
PERIOD = 0.4  # length of its variation along the guide, as a share of the travel
_REST = 0.1  # pause between moves [s]
_LEAST = 20  # samples in a move
_DEFLECTION = 1e-4  # presliding deflection over the command's speed where no stiffness is known [s]


@dataclass(frozen=True)
class Drive:
    """A drive of the family."""

    name: str = field(metadata=entry(key="drive"))  # how it differs from the fitted one
    law: str  # name of its friction law
    parameters: Values = field(metadata=entry(start_unit))  # of the drive FMU
    level: float = 1.0  # of its friction, over that in the log
    decides: bool = True  # whether a compensator has to help it, or is only shown on it


@dataclass(frozen=True, eq=False)
class Command:
    """A command on which drives are tried."""

    name: str  # display name
    v_cmd: Array  # (n,) one value a sample [m/s]
    drives: tuple[str, ...] = ()  # names of the drives that are tried on it; empty for all

    @property
    def speed(self) -> float:
        """Largest speed [m/s]."""
        return float(np.max(np.abs(self.v_cmd)))


@dataclass(frozen=True)
class Evidence:
    """What a log tells of a drive's friction besides the values that a compensator takes."""

    # that it supports, by name of the law: those fitted first, then draws
    draws: Mapping[str, Sequence[Values]] = field(default_factory=dict)
    levels: tuple[float, float] = field(default_factory=harm.levels)  # that it may come to have


def family(law: Law, friction: Values, command: Trapezoid, known: Evidence) -> tuple[Drive, ...]:
    """Return the drives on which a compensator is tried.

    Each of them, as fitted or drawn from what the log supports, has the friction of the log, and
    the least and the largest that it may come to have. Those drawn differ by direction or along the
    guide, in turn. Friction is given by parameters of the law, as the compensator takes them. The
    command is the fastest one, whose travel gives the period of friction along the guide.
    """
    along = {"position_amplitude": UNEVEN, "position_period": PERIOD * travel(command)}
    changes: list[Values] = [{"asymmetric": True, "asymmetry": UNEVEN}]
    changes += [{"position_dependent": True, **along}]
    named = {FITTED: (law, friction)}
    for name, draws in known.draws.items():
        own = friction_law(name)
        for k, (values, change) in enumerate(zip(draws, cycle(changes), strict=False)):
            named[f"{own.title} friction {k + 1}"] = own, {**values, **change, "seed": k}

    def at(name: str, level: float, *, decides: bool = True) -> Drive:
        own, values = named[name]
        shown = name if level == 1.0 else f"{name} x {level:g}"
        scaled = own.share(values, level)
        if name != FITTED:  # as by another lubricant: the contact is as stiff as before
            scaled |= {one: values[one] for one in PRESLIDING if one in values}
        return Drive(shown, own.name, scaled, level, decides=decides)

    levels = tuple(dict.fromkeys((1.0, *known.levels)))
    deciding = [at(name, level) for name in named for level in levels]
    return (*deciding, *(at(FITTED, one, decides=False) for one in BEYOND if one not in levels))


def speed_text(v: float, *, rotary: bool) -> str:
    """Return a speed [m/s or rad/s] in mm/s, or in mrad/s below 1 rad/s."""
    if rotary and v >= 1.0:
        return f"{v:.3g} rad/s"
    return f"{1e3 * v:.3g} {motion_unit('mm/s', rotary=rotary)}"


def commands(
    command: Trapezoid,  # the trapezoid at full speed
    T_s: float,
    friction: Values,
    encoder_step: float = 0.0,  # of which a move has several [m]
    stiffness: float = math.inf,  # force per travel of a loop whose drive is held [N/m]
    *,
    rotary: bool = False,
    drives: Sequence[Drive] = (),  # whose moves have the length of their own presliding
) -> tuple[Command, ...]:
    """Return the commands: a trapezoid at two speeds, creep that slides, and small moves."""
    found = [
        Command(
            speed_text(share * command.height, rotary=rotary),
            _slower(command, share, T_s, command.plateau),
        )
        for share in SPEEDS
    ]
    for share, (force, names) in creeps(drives, friction, command).items():
        found.append(Command(CREEP, _creep(command, share, T_s, force / stiffness), tuple(names)))
    bent = deflections(drives, command, encoder_step) or {"": (deflection(friction, command),)}
    for name, (times, steps, share) in MOVES.items():
        of_length: dict[float, list[str]] = {}
        for drive, own in ((drive, own) for drive, every in bent.items() for own in every):
            length = min(max(times * own, steps * encoder_step), share * travel(command))
            of_length.setdefault(float(f"{length:.6g}"), []).extend([drive] if drive else [])
        found += [
            Command(name, _moves(length, command, T_s), tuple(names))
            for length, names in of_length.items()
        ]
    return tuple(found)


def sweep(
    command: Trapezoid,
    T_s: float,
    drives: Sequence[Drive],
    encoder_step: float = 0.0,
    *,
    stiffness: float = math.inf,
    rise: float = 0.0,  # time of the loop [s]
) -> tuple[Command, ...]:
    """Return small moves of any length and creep at any speed, with what ``commands`` takes.

    Whether a loop just breaks away, or just does not, depends on them. The moves have from as many
    of the shortest presliding deflections to as many of the longest as those of ``commands``, and
    the speeds are about the Stribeck velocity.
    """
    bent = [own for every in deflections(drives, command, encoder_step).values() for own in every]
    shortest, longest = (
        min(times * own, share * travel(command))
        for (times, _, share), own in zip(MOVES.values(), (min(bent), max(bent)), strict=True)
    )
    lengths = np.geomspace(shortest, longest, SWEPT_MOVES).tolist()
    found = [
        Command(name, _moves(length, command, T_s, least, ways=ALTERNATING))
        for name, least in ((SWEEP[0], 0.0), (SLOW_MOVE, SLOW * rise))
        for length in lengths
    ]
    level = [one.parameters for one in drives if one.level == 1.0] or [drives[0].parameters]
    shares: tuple[float, ...] = CREEPS_OF_LEVEL
    if rising := [one["v_s"] for one in level if one.get("F_s", 0.0) > one["F_c"]]:
        slow = float(np.median(rising)) / abs(command.height)
        shares = tuple(min(max(k * slow, SLOWEST), FASTEST) for k in SWEPT_CREEPS)
    force = max(max(one.get("F_s", 0.0), one["F_c"]) for one in level)
    found += [
        Command(SWEEP[1], _creep(command, share, T_s, force / stiffness))
        for share in dict.fromkeys(shares)
    ]
    return tuple(found)


def onsets(
    law: Law, drives: Sequence[Drive], command: Trapezoid, encoder_step: float
) -> tuple[float, ...]:
    """Return from which displacements [m] on forces may act; none where a log shows presliding.

    Each leaves more small moves alone, in which the drive as fitted may stick. What a compensator
    takes is not the fit where the log does not show it.
    """
    bent = deflections(drives, command, encoder_step)
    own = [one for one in drives if one.level == 1.0 and one.law == law.name]
    taken, *drawn = [bent[one.name] for one in own if "sigma_0" in one.parameters] or [(0.0,)]
    if min((one[0] for one in drawn), default=taken[0]) >= harm.RESOLVED * encoder_step:
        return ()
    fit = max((drawn or [taken])[0]) or harm.RESOLVED * encoder_step
    fit = max(fit, harm.HIDDEN * encoder_step)
    return tuple(
        harm.ONSET * min(times * fit, share * travel(command)) for times, _, share in MOVES.values()
    )


def travel(command: Trapezoid) -> float:
    """Return how far a trapezoid moves in one direction [m]."""
    return abs(command.height) * (command.plateau + abs(command.height) / command.slope)


def deflections(
    drives: Sequence[Drive], command: Trapezoid, encoder_step: float
) -> dict[str, tuple[float, ...]]:
    """Return presliding deflections [m] at the friction of the log, by name of the drive.

    One of few encoder steps may be somewhat longer or shorter. A drive of a law without presliding
    has several, of which an encoder shows at most the longest.
    """
    several: tuple[float, ...] = (deflection({}, command),)
    if encoder_step:
        several = hidden_deflections(encoder_step, LENGTHS, LONGEST)
    level = {_base(one): one.parameters for one in reversed(drives)}
    found = {}
    for one in drives:
        own = deflection(level[_base(one)], command)
        sure = own >= harm.COARSE * encoder_step
        about = (own,) if sure else (own, own * harm.UNSURE, own / harm.UNSURE)
        found[one.name] = about if "sigma_0" in one.parameters else several
    return found


def hidden_deflections(encoder_step: float, n: int, longest: float = 1.0) -> tuple[float, ...]:
    """Return n presliding deflections [m], up to ``longest`` times what encoder steps [m] hide."""
    ends = harm.HIDDEN * encoder_step, longest * harm.RESOLVED * encoder_step
    return tuple(np.geomspace(*ends, n).tolist())


def deflection(friction: Values, command: Trapezoid) -> float:
    """Return the presliding deflection F_c / sigma_0 [m], or one typical of the speed."""
    if "sigma_0" in friction:
        return friction["F_c"] / friction["sigma_0"]
    return _DEFLECTION * abs(command.height)


def creeps(
    drives: Sequence[Drive], friction: Values, command: Trapezoid
) -> dict[float, tuple[float, list[str]]]:
    """Return the largest static friction [N] and the drives by speed of creep over the command's.

    A drive creeps below its own Stribeck velocity: as fitted at both speeds, as drawn at one of
    them, two draws at each in turn.
    """
    own = {_base(one): one.parameters for one in reversed(drives)} or {"": friction}
    order = [name for name in dict.fromkeys(map(_base, drives)) if name != FITTED]
    found: dict[float, tuple[float, list[str]]] = {}
    for name, values in own.items():
        F_s = max(values.get("F_s", 0.0), values["F_c"])
        shares: tuple[float, ...] = CREEPS_OF_LEVEL
        if F_s > values["F_c"]:
            ratio = values["v_s"] / abs(command.height)
            slow, fast = (min(max(k * ratio, SLOWEST), FASTEST) for k in reversed(CREEPS))
            shares = fast, slow
        if name in order:
            shares = shares[order.index(name) // 2 % 2 :][:1]
        for share in dict.fromkeys(float(f"{one:.3g}") for one in shares):
            force, names = found.get(share, (0.0, []))
            names += [one.name for one in drives if _base(one) == name]
            found[share] = max(force, F_s), names
    return found


def _base(drive: Drive) -> str:
    """Return the name of a drive without its level of friction."""
    return drive.name.partition(" x ")[0]


def _creep(command: Trapezoid, share: float, T_s: float, bent: float) -> Array:
    """Return creep at a share of a command's speed, until it is ``bent`` [m] ahead."""
    held = SLIPS[0] * bent / (share * abs(command.height))
    return _slower(command, share, T_s, max(command.plateau, min(held, SLIPS[1])))


def _slower(command: Trapezoid, share: float, T_s: float, plateau: float) -> Array:
    """Return samples of a command at a share of its speed."""
    slower = replace(command, height=share * command.height, slope=share * command.slope)
    slower = replace(slower, plateau=plateau)
    t = np.arange(round((slower.corners()[-1] + slower.begin) / T_s) + 1) * T_s
    return slower.sample(t)


def _moves(
    length: float,
    command: Trapezoid,
    T_s: float,
    least: float = 0.0,  # duration of each [s]
    *,
    ways: Sequence[int] = TWICE,  # direction of each
) -> Array:
    """Return smooth moves with the command's acceleration."""
    duration = max(
        math.sqrt(2.0 * math.pi * length / command.slope),
        2.0 * length / abs(command.height),
        _LEAST * T_s,
        least,
    )
    n = math.ceil(duration / T_s)
    move = length / (n * T_s) * (1.0 - np.cos(2.0 * np.pi * np.arange(n) / n))
    rest = np.zeros(math.ceil(_REST / T_s))
    return np.concatenate([rest, *(part for way in ways for part in (way * move, rest))])
