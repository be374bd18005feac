"""Several ways to control a drive, compared on several motions."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from stickslip.evaluation.motions import MOTIONS, Motion
from stickslip.evaluation.validation import (
    ONCE,
    Run,
    covered,
    repetitions,
    runs_of,
    summary,
    velocity_errors,
)
from stickslip.fmi.process import Threads
from stickslip.identification.criteria.runs import Diverged, require_bounded
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.measurement import Array
from stickslip.servo.velocity_loop import VelocityLoop

Key = tuple[str, str, str, str, str]  # an error, by the columns of ``KEYS``
KEYS = ["motion", "region", "velocity", "metric", "unit"]
"""The columns of ``Evaluation.table`` before those of the entries."""


@dataclass(frozen=True)
class Entry:
    """One way to control the drive."""

    loop: VelocityLoop  # the velocity loop
    compensator: Mapping[str, float] | None = None  # by name, None for no compensation
    # of further seeds; of the errors with them and with ``compensator`` the median counts
    others: Sequence[Mapping[str, float]] = ()


@dataclass(frozen=True)
class Evaluation:
    """All motions with all entries."""

    motions: tuple[Motion, ...]  # in the order in which they are shown
    runs: Mapping[str, Mapping[str, Run]]  # by motion, then entry: of its ``compensator``
    # by name of the entry, with the index ``KEYS`` and a column for each compensator and phase; NaN
    # where the drive runs away
    errors: Mapping[str, pd.DataFrame]

    def table(self) -> pd.DataFrame:
        """Return the errors, a row each, and for each entry a column of medians.

        The columns before those of the entries: motion, region, velocity (measured, true), metric
        (E_max, E_rms, E_x), unit (mm/s, for E_x um). E_x is the largest position error; for it
        ``velocity`` tells whether the position is the measured or the true one. Errors are NaN
        where the drive runs away. Behind all entries stand the ranges, see ``scatter.summary``.
        """
        return summary(self.errors).reset_index()


def evaluate(
    rig: FmuRig,
    entries: Mapping[str, Entry],
    motions: Sequence[Motion] = MOTIONS,
    phases: Sequence[float] = ONCE,
    workers: int = 1,
) -> Evaluation:
    """Run each motion with each entry at each phase, ``workers`` motions side by side."""
    commands = [motion.command.sample(rig.samples(motion.duration)) for motion in motions]
    top = max(float(np.max(np.abs(v_cmd))) for v_cmd in commands)

    def one(motion: Motion, v_cmd: Array) -> tuple[dict[str, Run], dict[str, pd.DataFrame]]:
        runs: dict[str, Run] = {}
        errors: dict[str, list[dict[Key, float]]] = {}
        for name, repeated in _runs(rig, entries, v_cmd, phases=phases):
            runs.setdefault(name, repeated[0])
            errors.setdefault(name, []).extend(motion_errors(run, motion, top) for run in repeated)
        return runs, {name: repetitions(found, KEYS) for name, found in errors.items()}

    with Threads(workers) as threads:
        found = threads.each(lambda pair: one(*pair), zip(motions, commands, strict=True))
    runs = {motion.name: each for motion, (each, _) in zip(motions, found, strict=True)}
    errors = {name: pd.concat(table[name] for _, table in found) for name in entries}
    return Evaluation(tuple(motions), runs, errors)


def _runs(
    rig: FmuRig, entries: Mapping[str, Entry], v_cmd: Array, phases: Sequence[float]
) -> Iterator[tuple[str, list[Run]]]:
    """Run one motion; the FMUs are prepared once for all compensators in the same loop."""
    alike: dict[int, list[str]] = {}
    for name, entry in entries.items():
        if entry.compensator is None:
            yield name, next(runs_of(rig, entry.loop, [None], v_cmd, phases=phases))
        else:
            alike.setdefault(id(entry.loop), []).append(name)
    for names in alike.values():
        tried = [(n, one) for n in names for one in (entries[n].compensator, *entries[n].others)]
        loop, compensators = entries[names[0]].loop, [one for _, one in tried]
        found = runs_of(rig, loop, compensators, v_cmd, phases=phases)
        yield from zip((name for name, _ in tried), found, strict=True)


def motion_errors(run: Run, motion: Motion, top: float) -> dict[Key, float]:
    """Return the errors by the columns of ``KEYS``; ``top`` is the largest command of any [m/s]."""
    errors = {
        (motion.name, region, velocity, metric, "mm/s"): 1e3 * value
        for (velocity, region, metric), value in velocity_errors(run, motion.regions).items()
    }
    if motion.positioned:
        for shown, x in (("measured", run.x_enc), ("true", run.x)):
            error = run.x_cmd - (x - x[0])
            for region, spans in motion.regions.items():
                largest = np.abs(error[covered(run.t, spans)]).max()
                errors[motion.name, region, shown, "E_x", "um"] = 1e6 * float(largest)
    try:
        require_bounded(run.v["true"], top)
    except Diverged:
        return dict.fromkeys(errors, math.nan)
    return errors
