"""Checks before export: where feedforward of friction would increase the tracking error.

``benefit`` tries compensators on a ``family`` of drives that the log supports, and finds the
largest share of the force that never increases the error. The guards return findings, one line
each: what, figure, limit, what to do. They evaluate a loop whose axis has exactly the friction that
the compensator assumes.

    stribeck      friction that falls with speed, against the damping of the loop
    tolerance     how much too large a force may be, compared with its confidence interval
    hunting       stick-slip at a constant command
    hold          the same at rest in a cascade, after motions of several sizes
"""

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager

import control
import numpy as np

from stickslip.catalog.parameters import ParameterSpace
from stickslip.cosim import Trapezoid
from stickslip.fmi.process import temporary_folder
from stickslip.models import Law
from stickslip.servo.axis import Axis, Datasheet
from stickslip.servo.measurement import Array, level, slope
from stickslip.servo.systems import Feed
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.thresholds import caution
from stickslip.trial.benefit import (
    FEEDFORWARD,
    NONE,
    Bench,
    Benefit,
    TrialError,
    Variant,
    best_of,
    feedforward,
)
from stickslip.trial.family import (
    Drive,
    Evidence,
    Finding,
    Run,
    Trial,
    commands,
    family,
    onsets,
    sweep,
)
from stickslip.trial.hold import Hold, holds, hunting_at_rest

MOST = 1.0  # share at which the search ends: twice the friction is as wrong as none
_BOUND = 1.96  # standard errors to a bound of the 95 % interval


def tolerance(trial: Trial, standard_errors: Mapping[str, float]) -> list[Finding]:
    """Return findings on forces that are too large, and on parameters at their 95 % bounds.

    Parameters without a standard error count as known.
    """
    with trial.runs(compensated=False) as run:
        without = run.error()
    with trial.runs(compensated=True) as run:
        return [*_too_large(run, without), *_at_bounds(run, without, standard_errors)]


def tolerated(run: Run, without: float) -> float:
    """Return the share by which friction may be too large before the error is that of none."""
    low, high = 0.0, MOST
    if run.error() >= without:
        return 0.0
    if _scaled(run, high) < without:
        return high
    while high - low > 0.02:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _scaled(run, middle) < without else (low, middle)
    return low


def _scaled(run: Run, share: float) -> float:
    p, law = run.trial.compensator, run.trial.law
    levels = [name for name, one in law.parameters.items() if one.unit == "N"]
    return run.error({name: (1.0 + share) * p[name] for name in levels})


def _too_large(run: Run, without: float) -> list[Finding]:
    share = tolerated(run, without)
    if share >= caution.TOO_LARGE:
        return []
    force = f"a force {100 * share:.0f} % too large" if share else "this force"
    message = (
        f"{force} makes the tracking error at least as large as without a"
        f" compensator, {_speed(run, without)}; expected {100 * caution.TOO_LARGE:g} % or more;"
        " raise K_p, or do not compensate on this command"
    )
    return [Finding("over-compensation", share, caution.TOO_LARGE, "1", message=message)]


def _at_bounds(run: Run, without: float, errors: Mapping[str, float]) -> list[Finding]:
    p, bounded = run.trial.compensator, ParameterSpace.of(run.trial.law).bounded
    worst, case = 0.0, ""
    for name, error in errors.items():
        for sign in (1.0, -1.0):
            value = max(p[name] + sign * _BOUND * error, 1e-3 * p[name])
            changed = {**p, name: value}
            for one, bound in bounded.items():
                changed[one] = max(changed[one], changed[bound])
            found = run.error(changed)
            if found > worst:
                worst, case = found, f"{name} = {value:.4g}"
    if worst <= without or run.error() >= without:
        return []
    message = (
        f"with {case}, a bound of its 95 % interval, the tracking error is {_speed(run, worst)};"
        f" expected at most that without a compensator, {_speed(run, without)}; learn from a"
        " recording that shows this parameter better"
    )
    return [
        Finding("uncertainty", worst, without, run.trial.loop.axis.unit("m/s"), message=message)
    ]


def _speed(run: Run, error: float) -> str:
    return f"{1e3 * error:.3g} {run.trial.loop.axis.unit('mm/s')}"


_SPEEDS = 60


def stribeck(trial: Trial) -> list[Finding]:
    """Return a finding when deviations grow too much while the command is at low speeds.

    About a steady speed v the force F of a contact approaches the curve g(v), with g' = dg/dv < 0:

        dF' = -a dF + a g' dv,   dF_f = dF + (sigma_1 / sigma_0) dF'

    For the bristles of (2) to (4), a = sigma_0 v / g; for the elements of GMS, a = C / g.

    Closed around the loop's compliance its fastest pole tells how a deviation grows at that speed.
    That speeds are passed where it grows does not matter; that the command dwells there does.
    """
    if trial.law.steady == "coulomb":
        return []
    speed = np.abs(trial.v_cmd)
    top = max(float(speed.max()), 1e-9)
    grid = np.geomspace(min(1e-3 * trial.friction["v_s"], 0.1 * top), top, _SPEEDS)
    rates = np.array([growth_rate(trial, v) for v in grid])
    # Below the least speed the bristle does not slide, and holds as a spring
    at = np.maximum(np.interp(speed, grid, rates, left=0.0), 0.0)
    figure = _longest(at * trial.loop.T_s)
    if figure <= caution.GROWTH:
        return []
    worst = float(speed[at.argmax()])
    falls, damping = -float(slope(trial.friction, worst)), trial.loop.K_p + trial.loop.axis.b
    unit = trial.loop.axis.unit
    message = (
        f"at {1e3 * worst:.3g} {unit('mm/s')} friction falls by {falls:.4g} {unit('N s/m')} against"
        f" a damping K_p + b of {damping:.4g} {unit('N s/m')}, and while the command is at such"
        f" speeds a deviation grows by e^{figure:.3g}; expected at most e^{caution.GROWTH:g}; raise"
        " K_p, or pass these speeds faster"
    )
    return [Finding("stribeck", figure, caution.GROWTH, "1", message=message)]


def growth_rate(trial: Trial, v: float) -> float:
    """Return the rate [1/s] at which a small deviation from a steady speed [m/s] grows."""
    p, loop = trial.friction, trial.loop.compliance
    g = float(level(p, v))
    a, c = _approach(p, v, g), float(slope(p, v))
    stretch = p["sigma_1"] / p["sigma_0"] if "sigma_1" in p else 0.0
    if a == np.inf:
        contact = control.ss([], [], [], c, trial.loop.T_s)
    else:
        continuous = control.ss(-a, a * c, 1.0 - stretch * a, stretch * a * c)
        contact = control.sample_system(continuous, trial.loop.T_s)
    A = np.block(
        [
            [loop.A - loop.B @ contact.D @ loop.C, -loop.B @ contact.C],
            [contact.B @ loop.C, contact.A],
        ]
    )
    return float(np.log(np.abs(np.linalg.eigvals(A)).max()) / trial.loop.T_s)


def _approach(p: Mapping[str, float], v: float, g: float) -> float:
    """Return the rate [1/s] at which the force approaches g(v); infinite without presliding."""
    if "C" in p:
        return p["C"] / g
    return p["sigma_0"] * v / g if "sigma_0" in p else np.inf


def _longest(growth: Array) -> float:
    """Return the largest sum over samples in a row that are not 0."""
    ends = np.flatnonzero(np.diff(growth > 0.0, prepend=False, append=False))
    total = np.concatenate([[0.0], np.cumsum(growth)])
    sums = total[ends[1::2]] - total[ends[::2]]
    return float(sums.max(initial=0.0))


HOLD = 1.0  # for how long the end of the command is held, to see what goes on there [s]


def hunting(trial: Trial) -> list[Finding]:
    """Return a finding for the plateau on which the compensated loop swings most.

    The second half of each plateau is evaluated: its velocity may swing by its own speed, or by v_s
    where it is slower than that.
    """
    held = np.full(round(HOLD / trial.loop.T_s), trial.v_cmd[-1])
    longer = dataclasses.replace(trial, v_cmd=np.concatenate([trial.v_cmd, held]))
    with longer.runs(compensated=True) as run:
        v = run.velocity()
    findings = []
    still = caution.STANDING * float(np.abs(trial.v_cmd).max())
    for begin, end in _plateaus(longer.v_cmd, round(caution.PLATEAU / trial.loop.T_s)):
        speed = abs(float(longer.v_cmd[begin]))
        swing = float(np.ptp(v[(begin + end) // 2 : end]))
        limit = max(speed, trial.friction.get("v_s", still))
        if swing > limit:
            findings.append(_finding(speed, swing, limit, trial.loop.axis))
    return sorted(findings, key=lambda finding: finding.limit / finding.figure)[:1]


def _finding(speed: float, swing: float, limit: float, axis: Axis) -> Finding:
    unit = axis.unit("mm/s")
    message = (
        f"the velocity swings by {1e3 * swing:.3g} {unit} while {1e3 * speed:.3g} {unit} is"
        f" commanded; expected at most {1e3 * limit:.3g} {unit}; raise K_p, lower K_i, or command"
        " faster"
    )
    return Finding("hunting", swing, limit, axis.unit("m/s"), message=message)


def _plateaus(v_cmd: Array, least: int) -> Iterator[tuple[int, int]]:
    """Yield begin and end of the stretches on which the command is constant."""
    constant = np.abs(np.diff(v_cmd)) <= 1e-12
    ends = np.flatnonzero(np.diff(constant, prepend=False, append=False))
    for begin, end in zip(ends[::2], ends[1::2], strict=True):
        if end - begin >= least:
            yield int(begin), int(end)


__all__ = [
    "NONE",
    "Bench",
    "Benefit",
    "Drive",
    "Evidence",
    "Finding",
    "Hold",
    "Trial",
    "TrialError",
    "Variant",
    "bench_of",
    "best_of",
    "commands",
    "family",
    "feedforward",
    "findings_of",
    "holds",
    "hunting",
    "hunting_at_rest",
    "inspect",
    "retried",
    "stribeck",
    "tolerance",
]


def inspect(trial: Trial, standard_errors: dict[str, float]) -> list[Finding]:
    """Return what all guards find; standard errors in the units of the parameters, some or none."""
    return [*stribeck(trial), *tolerance(trial, standard_errors), *hunting(trial)]


def retried(
    bench: Bench,
    friction: Mapping[str, float],  # as fitted, parameters of the law by name
    variant: Variant,
    standard_errors: Mapping[str, float],  # of the friction, by name
    *,
    force: bool = False,  # whether the guards take the whole force, not the acceptable share
) -> tuple[Benefit, list[Finding]]:
    """Try a way to compensate, with a share of its force only where the whole is not acceptable.

    Returns
    -------
    benefit : of the variant
    findings : of all guards
    """
    (benefit,) = bench.benefits([variant], shares=(1.0,))
    if not benefit.acceptable:
        (benefit,) = bench.benefits([variant])
    share = 1.0 if force else benefit.share
    found = findings_of(bench, friction, benefit, share, standard_errors=standard_errors)
    if bench.loop.K_x:
        shared, step = variant.share(bench.law, share), bench.datasheet.encoder_step
        found += hunting_at_rest(holds(bench, [NONE, shared]), shared, step)
    return benefit, found


@contextmanager
def bench_of(
    law: Law,  # of the feedforward
    loop: VelocityLoop,
    friction: Mapping[str, float],  # as fitted, parameters of the law by name
    drives: Sequence[Drive],  # see ``family``
    command: Trapezoid,  # at the highest speed; see ``commands``
    datasheet: Datasheet,
    *,
    feed: Feed = "nominal",
    workers: int = 1,
) -> Iterator[Bench]:
    """Build the loop in which variants are tried."""
    with temporary_folder() as folder:
        step, rotary = datasheet.encoder_step, loop.axis.rotary
        stiffness = loop.K_i + loop.K_p * loop.K_x
        tried = commands(
            command,
            loop.T_s,
            friction,
            step,
            stiffness=stiffness,
            rotary=rotary,
            drives=drives,
        )
        bench = Bench(
            folder,
            law,
            loop,
            drives,
            commands=tried,
            feed=feed,
            datasheet=datasheet,
            workers=workers,
            onsets=onsets(law, drives, command, step),
            sweep=sweep(command, loop.T_s, drives, step, stiffness=stiffness),
        )
        with closing(bench):
            yield bench


def findings_of(
    bench: Bench,
    friction: Mapping[str, float],
    benefit: Benefit,
    share: float,
    standard_errors: Mapping[str, float],
) -> list[Finding]:
    """Return what all guards find on a share of the feedforward of a variant.

    They evaluate a law, in a loop that does not run away on the drive as fitted.
    """
    if benefit.variant.feedforward_kind != (FEEDFORWARD, "") or benefit.fitted_ratio == math.inf:
        return []
    trial = Trial(
        bench.folder_of(bench.law.name),
        bench.loop,
        friction,
        benefit.variant.share(bench.law, share).feedforward,
        v_cmd=bench.commands[0].v_cmd,
        feed=bench.feed,
        datasheet=bench.datasheet,
        law=bench.law,
    )
    return inspect(trial, dict(standard_errors))
