"""All motions: the compensators compared, a weak loop, and what each motion shows.

What a motion shows of a parameter is what an exact compensator loses there with it made wrong.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from stickslip.catalog.parameters import parameter
from stickslip.evaluation.comparison import Entry, Evaluation, evaluate
from stickslip.evaluation.motions import MOTIONS, Motion
from stickslip.evaluation.scatter import PHASES, summary
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.systems import Feed
from stickslip.servo.velocity_loop import VelocityLoop, close_velocity_loop

UNCOMPENSATED, IDENTIFIED, LEARNED = "without", "identified", "learned"
"""Names of entries: no compensation, the identified parameters, the learned ones."""
WEAK = 0.1
"""Bandwidth of the weak loop, as a share of that of the loop."""
WEAK_ENTRIES = ("weak loop, without", "weak loop, exact")
"""The columns of the weak loop, without and with an exact compensator."""

FACTORS = {"v_s": (1 / 3, 3.0)}
"""By what a parameter is made wrong, where that is not a half and twice."""
CONTROL = ("F_c", "x 1.001")
"""A change too small to matter: what it costs is chance, as the encoder's steps fall elsewhere."""
SEEN = 0.10
"""A motion sees that a parameter is wrong where that costs this much of the reduction (9)."""


@dataclass(frozen=True)
class MotionStudy:
    """What the motions gave.

    Attributes
    ----------
    loops : of the entries by name
    evaluation : of the entries, and after them of ``WEAK_ENTRIES``
    sensitivity : what ``sensitivity`` returns
    weak : the weak loop
    """

    loops: Mapping[str, VelocityLoop]
    evaluation: Evaluation
    sensitivity: pd.DataFrame
    weak: VelocityLoop

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the entries, those of the weak loop left out."""
        runs = next(iter(self.evaluation.runs.values()))
        return tuple(name for name in runs if name not in WEAK_ENTRIES)


def limits(table: pd.DataFrame, names: Mapping[str, str]) -> str:
    """Return where the learned compensator gains little, and where it makes an error larger.

    Parameters
    ----------
    table : of ``Evaluation.table``, of the slow motions
    names : of metrics, as they are shown
    """
    left = table[LEARNED] / table[UNCOMPENSATED]
    worse, little = (
        "; ".join(
            f"{error_name(row, names)}, {row['velocity']} "
            f"({100.0 * row[LEARNED] / row[UNCOMPENSATED]:.0f} %)"
            for row in table[found].to_dict("records")
        )
        for found in (left > 1.0, (left > 0.5) & (left <= 1.0))
    )
    text = "The learned compensator makes none of these errors larger"
    if worse:
        text = f"The learned compensator makes these errors larger: {worse}"
    if little:
        text += f". It leaves more than half of these: {little}"
    if IDENTIFIED in table:
        change = table[LEARNED] / table[IDENTIFIED]
        text += (
            f". Of these {len(table)} errors, those of the learned compensator are larger than "
            f"those of the identified one by more than a tenth in {int((change > 1.1).sum())}, "
            f"and smaller by more than a tenth in {int((change < 0.9).sum())}"
        )
    return text


def error_name(row: Mapping[Hashable, object], names: Mapping[str, str]) -> str:
    """Return what an error of ``Evaluation.table`` is of."""
    return f"{str(row['motion']).capitalize()}, {row['region']}, {names[str(row['metric'])]}"


def study_motions(
    rig: FmuRig,
    entries: Mapping[str, Entry],
    loop: VelocityLoop,
    exact: Mapping[str, float],
    feed: Feed = "nominal",
    phases: Sequence[float] = PHASES,
    workers: int = 1,
) -> MotionStudy:
    """Run all motions.

    It may use the true values, since it evaluates and does not learn.

    Parameters
    ----------
    entries : what is compared, ``UNCOMPENSATED`` and ``LEARNED`` among them
    loop : in which the sensitivity is found, and of which the weak one is made
    exact : the parameters of the exact compensator by name
    phases : at which each is run, see ``scatter.py``
    workers : motions side by side
    """
    weak = weakened(loop)
    weak_entries = dict(zip(WEAK_ENTRIES, (Entry(weak), Entry(weak, exact)), strict=True))
    evaluation = evaluate(rig, {**entries, **weak_entries}, feed, phases=phases, workers=workers)
    loops = {name: entry.loop for name, entry in entries.items()}
    shown = sensitivity(rig, loop, exact, feed, phases=phases, workers=workers)
    return MotionStudy(loops, evaluation, shown, weak)


def weakened(loop: VelocityLoop) -> VelocityLoop:
    """Return the loop with a tenth of the bandwidth: K_p in proportion to it, K_i to its square."""
    gains = WEAK * loop.K_p, WEAK**2 * loop.K_i
    return close_velocity_loop(loop.axis, loop.T_s, loop.tau_f, *gains)


def wrong_values(exact: Mapping[str, float]) -> dict[tuple[str, str], dict[str, float]]:
    """Return compensators with one parameter wrong, by name and change; last ``CONTROL``."""
    wrong = {
        (name, f"= {bound}"): {**exact, name: exact[bound]}
        for name in exact
        if (bound := parameter(name).at_least)
    }
    for name in exact:
        for factor in FACTORS.get(name, (0.5, 2.0)):
            change = f"x {factor:g}" if factor >= 1.0 else f"/ {1 / factor:g}"
            wrong[name, change] = {**exact, name: factor * exact[name]}
    return {**wrong, CONTROL: {**exact, "F_c": 1.001 * exact["F_c"]}}


def sensitivity(
    rig: FmuRig,
    loop: VelocityLoop,
    exact: Mapping[str, float],
    feed: Feed = "nominal",
    motions: Sequence[Motion] = MOTIONS,
    phases: Sequence[float] = PHASES,
    workers: int = 1,
) -> pd.DataFrame:
    """Return the errors of the drive's true motion with each parameter wrong, in every region.

    Columns: parameter, change, motion, region, metric (E_rms of the velocity, E_x of the position),
    unit; ``without``, ``exact`` and ``wrong``, the errors without compensation, with the exact
    compensator and with the wrong one; ``lost``, by how much the reduction (9) falls, a fraction:
    medians over the phases, and the ranges, see ``scatter.summary``.

    Parameters
    ----------
    exact : the drive's true parameters by name
    """
    wrong = wrong_values(exact)
    entries = {"without": Entry(loop), "exact": Entry(loop, exact)}
    entries |= {" ".join(key): Entry(loop, values) for key, values in wrong.items()}
    errors = evaluate(rig, entries, feed, motions, phases, workers).errors
    without, exact_ones = errors["without"], errors["exact"]
    frames = []
    for name, change in wrong:
        one = errors[f"{name} {change}"]
        found = {"without": without, "exact": exact_ones, "wrong": one}
        frame = summary({**found, "lost": (one - exact_ones) / without}).reset_index()
        frame = frame[(frame["velocity"] == "true") & (frame["metric"] != "E_max")]
        frame.insert(0, "parameter", name)
        frame.insert(1, "change", change)
        frames.append(frame.drop(columns="velocity"))
    return pd.concat(frames, ignore_index=True)


def by_motion(shown: pd.DataFrame) -> pd.DataFrame:
    """Return the largest ``lost`` of each motion, a column each, by parameter and change."""
    lost = shown.pivot_table(
        index=["parameter", "change"], columns="motion", values="lost", aggfunc="max", sort=False
    )
    return lost.loc[list(dict.fromkeys(zip(shown["parameter"], shown["change"], strict=True)))]


def unseen(lost: pd.DataFrame) -> list[tuple[str, str]]:
    """Return the parameters and changes that no motion among the columns sees."""
    largest = lost.drop(index=CONTROL).max(axis=1)
    return list(largest.index[largest < SEEN])
