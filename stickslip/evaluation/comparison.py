"""Several ways to control a drive, compared on several motions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain

import numpy as np
import pandas as pd

from stickslip.evaluation.motions import MOTIONS, Motion
from stickslip.evaluation.validation import (
    Run,
    covered,
    run_command,
    run_compensators,
    velocity_errors,
)
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.divergence import Diverged, require_bounded
from stickslip.servo.systems import Feed
from stickslip.servo.velocity_loop import VelocityLoop

Key = tuple[str, int]
"""The name of an entry, and which of its compensators."""

KEYS = ["motion", "region", "velocity", "metric", "unit"]
"""The columns of ``Evaluation.table`` before those of the entries."""


@dataclass(frozen=True)
class Entry:
    """One way to control the drive.

    Attributes
    ----------
    loop : the velocity loop
    compensator : its parameters by name, None for no compensation
    others : of further seeds; of the errors with them and with ``compensator`` the median counts
    """

    loop: VelocityLoop
    compensator: Mapping[str, float] | None = None
    others: Sequence[Mapping[str, float]] = ()


@dataclass(frozen=True)
class Evaluation:
    """All motions with all entries.

    Attributes
    ----------
    motions : in the order in which they are shown
    runs : by name of the motion, then of the entry; of its ``compensator``
    others : the runs of ``Entry.others``, likewise
    """

    motions: tuple[Motion, ...]
    runs: Mapping[str, Mapping[str, Run]]
    others: Mapping[str, Mapping[str, Sequence[Run]]] = field(default_factory=dict)

    def table(self) -> pd.DataFrame:
        """Return the errors, a row each and a column for each entry.

        The columns before those of the entries: motion, region, velocity (measured, true), metric
        (E_max, E_rms, E_x), unit (mm/s, for E_x um). E_x is the largest position error; for it
        ``velocity`` tells whether the position is the measured or the true one. Errors are NaN
        where the drive runs away.
        """
        columns = []
        runs = chain.from_iterable(of.values() for of in self.runs.values())
        top = max(float(np.max(np.abs(run.v_cmd))) for run in runs)
        for name in next(iter(self.runs.values())):
            errors = {}
            for motion in self.motions:
                others = self.others.get(motion.name, {}).get(name, ())
                each = [
                    _errors(run, motion, top) for run in (self.runs[motion.name][name], *others)
                ]
                errors.update(pd.DataFrame(each).median(skipna=False).to_dict())
            columns.append(pd.Series(errors, name=name))
        return pd.concat(columns, axis=1).rename_axis(index=KEYS).reset_index()


def evaluate(
    rig: FmuRig,
    entries: Mapping[str, Entry],
    feed: Feed = "nominal",
    motions: Sequence[Motion] = MOTIONS,
) -> Evaluation:
    """Run each motion with each entry. It may use the true values."""
    each = {(name, -1): entry for name, entry in entries.items()}
    each |= {
        (name, place): Entry(entry.loop, values)
        for name, entry in entries.items()
        for place, values in enumerate(entry.others)
    }
    runs: dict[str, Mapping[str, Run]] = {}
    others: dict[str, Mapping[str, Sequence[Run]]] = {}
    for motion in motions:
        done = _runs(rig, each, feed, motion)
        runs[motion.name] = {name: done[name, -1] for name in entries}
        others[motion.name] = {
            name: [done[name, place] for place in range(len(entry.others))]
            for name, entry in entries.items()
        }
    return Evaluation(tuple(motions), runs, others)


def _runs(rig: FmuRig, entries: Mapping[Key, Entry], feed: Feed, motion: Motion) -> dict[Key, Run]:
    """Run one motion; the FMUs are prepared once for all compensators in the same loop."""
    v_cmd = motion.command.sample(rig.samples(motion.duration))
    runs = {
        name: run_command(rig, entry.loop, None, v_cmd, feed)
        for name, entry in entries.items()
        if entry.compensator is None
    }
    alike: dict[int, dict[Key, Mapping[str, float]]] = {}
    for name, entry in entries.items():
        if entry.compensator is not None:
            alike.setdefault(id(entry.loop), {})[name] = entry.compensator
    for compensators in alike.values():
        loop = entries[next(iter(compensators))].loop
        done = run_compensators(rig, loop, compensators.values(), v_cmd, feed)
        runs.update(zip(compensators, done, strict=True))
    return runs


def _errors(run: Run, motion: Motion, top: float) -> dict[tuple[str, str, str, str, str], float]:
    """Return the errors by the columns of ``KEYS``, in the unit that is stated.

    Parameters
    ----------
    top : the largest velocity that is commanded in any motion [m/s]
    """
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
