"""Hunting: a cascade with integral action that does not come to rest where friction holds it.

Held with a position error, the integral raises the force until the drive breaks away. With F_s
above F_c it slips past the target and is held again, on the other side. In the linear loop a force
meets the stiffness K_p K_x + K_i, so a slow slip is at most about (F_s - F_c) / (K_p K_x + K_i)
long; the integral then needs (F_s + F_c) / (K_i K_x e) for the way back, with e half of that. The
drive is held for ``PERIODS`` of that cycle after a motion, and after a small move behind it. Their
targets lie between two encoder steps, where the integral never rests.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stickslip import cosim
from stickslip.identification.criteria.runs import Outcome, Runs, bounded
from stickslip.servo.lanes import Run
from stickslip.servo.measurement import Array, turns
from stickslip.servo.systems import build_loop
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.storage.codec import entry
from stickslip.thresholds import caution
from stickslip.trial.benefit import Bench, Variant, feed_of
from stickslip.trial.family import Drive, axis_values, in_loop

SHORTEST, LONGEST, PERIODS = 1.0, 20.0, 8.0
"""Of a hold [s], and how many periods of the limit cycle to be expected it has."""
MOVES = (0.0, 3.5, 25.5, 250.5)  # lengths of the moves before a hold, in encoder steps
RISE = 20  # samples of such a move


@dataclass(frozen=True)
class Hold:
    """How far a drive swings at rest, at worst of several motions and drives."""

    swing: float = field(metadata=entry("m"))  # of the true position, peak to peak [m]
    reversals: int  # changes of direction there, by more than half of swing and encoder step
    duration: float = field(metadata=entry("s"))  # of the second half of the hold
    drive: str = ""  # on which
    unit: str = field(default="um", metadata=entry(stored=False))  # of a millionth of a position

    def hunts(self, limit: float) -> bool:
        """Tell whether it goes to and fro, farther than a limit [m]."""
        return self.swing > limit and self.reversals >= caution.REVERSALS


def hold_time(loop: VelocityLoop, friction: Mapping[str, float], step: float) -> float:
    """Return how long a drive is held: periods of a limit cycle, whose error is at least a step."""
    integral, F_c = loop.K_i * loop.K_x, friction["F_c"]
    if not integral:
        return SHORTEST
    F_s = max(friction.get("F_s", F_c), F_c)
    slip = max((F_s - F_c) / (loop.K_p * loop.K_x + loop.K_i), step)
    period = 2.0 * (F_s + F_c) / (integral * 0.5 * slip)
    return float(np.clip(PERIODS * period, SHORTEST, LONGEST))


def holds(bench: Bench, variants: Iterable[Variant]) -> dict[str, Hold]:
    """Return how a cascade holds its position with each variant, by its name.

    It runs on the first drive of each law, after the bench's first command and after small moves.
    """
    drives = {one.law: one for one in reversed(bench.drives)}
    return {
        variant.name: _worst(_held(bench, drive, variant) for drive in drives.values())
        for variant in variants
    }


def hunting_at_rest(found: Mapping[str, Hold], compensated: Variant, step: float) -> list[str]:
    """Return a warning where a drive hunts with a variant; ``found`` has that of none as well."""
    hold, limit = found[compensated.name], caution.SWING * step
    if not hold.hunts(limit):
        return []
    return [
        f"hunting: {described(hold)} with the compensator on a drive with {hold.drive}, and"
        f" {described(found['none'])} without; expected at most {1e6 * limit:.3g} {hold.unit};"
        " switch the integral off at rest, lower K_i, or raise K_p"
    ]


def described(hold: Hold) -> str:
    """Return what a hold showed."""
    if not np.isfinite(hold.swing):
        return "at rest the position runs away"
    return (
        f"at rest the position swings by {1e6 * hold.swing:.3g} {hold.unit} with"
        f" {hold.reversals} reversals in {hold.duration:.3g} s"
    )


def _held(bench: Bench, drive: Drive, variant: Variant) -> Hold:
    loop, step = bench.loop, bench.datasheet.encoder_step
    n = round(hold_time(loop, drive.parameters, step) / loop.T_s)
    every = _commands(bench.commands[0].v_cmd, step, n, loop.T_s)
    feed = feed_of(variant.chain)
    system = build_loop(bench.fmus(drive.law, variant.chain), loop, variant.chain, feed)
    system.parameters |= in_loop({**axis_values(loop, bench.datasheet), **drive.parameters})
    stop = (len(every[0]) - 1) * loop.T_s
    whole = cosim.Specification(system, step=loop.T_s, stop=stop, record=("drive.x", "drive.v"))
    about: Any = {"drive": drive.name, "unit": loop.axis.unit("um"), "duration": 0.5 * n * loop.T_s}

    def hold(v_cmd: Array, run: Outcome) -> Hold:
        run = bounded(run, "drive.v", float(np.max(np.abs(v_cmd))))
        if isinstance(run, cosim.SimulationError):
            return Hold(swing=np.inf, reversals=int(caution.REVERSALS), **about)
        half = run["drive.x"][-(n // 2) :]
        return Hold(float(np.ptp(half)), reversals(half, 0.5 * step), **about)

    with Runs(whole, bench.workers) as runs:
        found = runs.batch([Run(variant.parameters, loop.commands(v_cmd)) for v_cmd in every])
    return _worst(map(hold, every, found))


def _worst(found: Iterable[Hold]) -> Hold:
    return max(found, key=lambda hold: (hold.reversals >= caution.REVERSALS, hold.swing))


def _commands(v_cmd: Array, step: float, n: int, T_s: float) -> list[Array]:
    """Return a command (m,) with a rest, a small move and n samples of rest behind it, by move."""
    shape = (1.0 - np.cos(2.0 * np.pi * np.arange(RISE) / RISE)) / (RISE * T_s)
    before, hold = np.append(v_cmd, np.zeros(round(SHORTEST / T_s))), np.zeros(n)
    return [np.concatenate([before, length * step * shape, hold]) for length in MOVES]


def reversals(x: Array, least: float) -> int:
    """Return how often a position (n,) turns back by half of its range and ``least`` [m]."""
    return turns(x, max(0.5 * float(np.ptp(x)), least))
