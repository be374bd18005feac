"""What each step brings: Table 4 with a column for each way to control the drive."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from stickslip.evaluation.motion_study import LEARNED
from stickslip.pipeline.reproduction import Reproduction
from stickslip.pipeline.steps import STEPS
from stickslip.report.markup import (
    Html,
    element,
    join,
    paragraph,
    symbol,
    table,
)
from stickslip.report.picture import Picture
from stickslip.report.quantity import number, percent
from stickslip.report.shown import METRICS, figure
from stickslip.servo.tuned_pi import peak_sensitivity

SCATTER = 0.02
"""Relative change of an error below which a step is said to have changed nothing."""


def write(reproduction: Reproduction, pictures: Mapping[str, Picture]) -> Html:
    """Return the section, nothing where the steps were not compared."""
    if reproduction.motions is None:
        return Html()
    own = _named(reproduction.table4())
    parts = [
        element("h2", "What each step brings"),
        paragraph(
            "The same drive, controlled step by step: the paper’s loop without compensation "
            "(none); a PI controller alone, its gains tuned against friction at the same peak "
            "sensitivity; a compensator with the identified parameters; one learned as published "
            "from coarse starts (median over seeds); the default from some of these starts "
            "(coarse); the default, which begins at the identified parameters; one learned from a "
            "single recording; and the same with velocity filter and feedforward of inertia (and "
            "filter).",
        ),
        figure(
            pictures["steps"],
            "Errors of Table 4 on the true velocity, step by step",
            "Errors (8a), (8b) on the drive’s true velocity. The shaded bands are the range of the "
            "real stage’s four errors (paper), which were measured.",
        ),
        _errors(own, "Table 4, step by step: the simulated drive [mm/s]"),
        _pi(reproduction),
        _learning(own, "the simulated drive"),
    ]
    extras = reproduction.extras
    if extras and extras.table4 is not None:
        table4 = _named(extras.table4)
        parts += [
            _errors(table4, "Table 4, step by step: the simulated drive, all extras on [mm/s]"),
            _learning(table4, "the drive with all extras on"),
        ]
    return element("section", join(parts, "\n"))


def _named(table4: pd.DataFrame) -> pd.DataFrame:
    return table4.rename(columns={"with": LEARNED})


def _errors(table4: pd.DataFrame, caption: str) -> Html:
    names = [name for name in STEPS if name in table4]
    rows = [
        (
            join([f"{row['region'].capitalize()}, ", METRICS[str(row["metric"])]]),
            str(row["velocity"]),
            *(f"{row[name]:.3f}" for name in names),
        )
        for row in table4.to_dict("records")
    ]
    return table(("", "", *(STEPS[name] for name in names)), rows, caption, (0, 1))


def _pi(reproduction: Reproduction) -> Html:
    assert reproduction.motions is not None  # noqa: S101 - the section is not written without
    tuned, loop = reproduction.motions.loops["tuned_pi"], reproduction.identification.loop
    return paragraph(
        "The tuned PI controller has ",
        symbol("K", "p"),
        f" = {number(tuned.K_p)} N s/m and ",
        symbol("K", "i"),
        f" = {number(tuned.K_i)} N/m instead of {number(loop.K_p)} and {number(loop.K_i)}, at a "
        f"peak sensitivity of {number(peak_sensitivity(loop), 3)} in both. The windows of Table 4 "
        "begin 30 ms after the reversal, when much integral gain has already pushed through most "
        "of the friction: a comparison with a softly tuned loop flatters every compensator.",
    )


def _learning(table4: pd.DataFrame, drive: str) -> Html:
    """Return whether learning did better than identification, on the true velocity."""
    true = table4[(table4["velocity"] == "true") & (table4["metric"] == "E_rms")]
    said = []
    for name in ("as_published", "coarse_default", LEARNED, "one_recording"):
        if name not in true:
            continue
        change = true[name] / true["identified"] - 1.0
        if (change.abs() < SCATTER).all():
            verdict = "changed nothing"
        else:
            steps = ", ".join(
                f"{'+' * (value > 0)}{percent(value, 0)} at the {region}"
                for value, region in zip(change, true["region"], strict=True)
            )
            verdict = f"changed the RMS error by {steps}"
        said.append(f"{STEPS[name].lower()} {verdict}")
    found = "; ".join(said).replace("-", "−")
    return paragraph(
        f"Against identification alone, on the true velocity of {drive}: {found}.",
    )
