"""What each motion shows of each parameter: an exact compensator with one parameter made wrong."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pandas as pd

from stickslip.catalog.parameters import parameter
from stickslip.evaluation.comparison import Entry, evaluate
from stickslip.evaluation.motions import MOTIONS, Motion
from stickslip.servo.rig import Rig
from stickslip.servo.systems import Feed
from stickslip.servo.velocity_loop import VelocityLoop

FACTORS = {"v_s": (1 / 3, 3.0)}
"""By what a parameter is made wrong, where that is not a half and twice."""
CONTROL = ("F_c", "x 1.001")
"""A change too small to matter: what it costs is chance, as the encoder's steps fall elsewhere."""
SEEN = 0.10
"""A motion sees that a parameter is wrong where that costs this much of the reduction (9)."""


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
    rig: Rig,
    loop: VelocityLoop,
    exact: Mapping[str, float],
    feed: Feed = "nominal",
    motions: Sequence[Motion] = MOTIONS,
) -> pd.DataFrame:
    """Return the errors of the drive's true motion with each parameter wrong, in every region.

    Columns: parameter, change, motion, region, metric (E_rms of the velocity, E_x of the position),
    unit; ``without``, ``exact`` and ``wrong``, the errors without compensation, with the exact
    compensator and with the wrong one; ``lost``, by how much the reduction (9) falls, a fraction.

    Parameters
    ----------
    exact : the drive's true parameters by name
    """
    wrong = wrong_values(exact)
    entries = {"without": Entry(loop), "exact": Entry(loop, exact)}
    entries |= {" ".join(key): Entry(loop, values) for key, values in wrong.items()}
    table = evaluate(rig, entries, feed, motions).table()
    table = table[(table["velocity"] == "true") & (table["metric"] != "E_max")]
    frames = []
    for name, change in wrong:
        frame = table[["motion", "region", "metric", "unit", "without", "exact"]].copy()
        frame.insert(0, "parameter", name)
        frame.insert(1, "change", change)
        frame["wrong"] = table[f"{name} {change}"]
        frames.append(frame)
    shown = pd.concat(frames, ignore_index=True)
    shown["lost"] = (shown["wrong"] - shown["exact"]) / shown["without"]
    return shown


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
