"""The slow motions: their errors, and what each motion shows of each parameter."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from functools import partial

import pandas as pd

from stickslip.evaluation.motion_study import (
    IDENTIFIED,
    LEARNED,
    UNCOMPENSATED,
    WEAK_ENTRIES,
    MotionStudy,
)
from stickslip.evaluation.motions import MOTIONS, SLOW_MOTIONS
from stickslip.evaluation.sensitivity import SEEN, by_motion, unseen
from stickslip.evaluation.validation import reduction
from stickslip.pipeline.reproduction import Reproduction
from stickslip.pipeline.steps import STEPS
from stickslip.report.markup import Html, element, join, paragraph, table
from stickslip.report.page import Illustration, Section
from stickslip.report.quantity import METRICS, number, percent, symbol
from stickslip.report.reproduction.curves import draw_motions
from stickslip.servo.datasheet import REGION, VALIDATION

TRAPEZOID, CREEP = MOTIONS[0], SLOW_MOTIONS[1]
SHOWN = METRICS | {"E_x": "$E_x$"}


def motions_section(reproduction: Reproduction) -> Section | None:
    """Return the section on the other motions, None where they were not run."""
    study = reproduction.motions
    if study is None:
        return None
    slowest, fastest = (1e3 * VALIDATION.slope * edge for edge in REGION)
    frame = study.evaluation.table()
    slow = frame[frame["motion"] != TRAPEZOID.name]
    purposes = (
        element("li", element("b", motion.name.capitalize()), f". {motion.purpose}")
        for motion in SLOW_MOTIONS
    )
    return Section(
        "Slow reversals, creep and micrometre moves",
        paragraph(
            f"The errors of Table 4 are taken at speeds of {number(slowest, 2)} to "
            f"{number(fastest, 2)} mm/s, where friction with the paper’s parameters is close to "
            "$F_c$; the other four hardly change them. Three more motions, which the learning "
            "never saw, are slower or shorter:",
        ),
        element("ul", join(purposes, "\n")),
        Illustration(
            "motions",
            partial(draw_motions, reproduction),
            "Velocity or position against time in the three motions, without and with compensation",
            "The simulated drive in the three motions: command, measured motion without "
            "compensation and with the learned compensator.",
        ),
        paragraph(
            "$E_{max}$ and $E_{rms}$ are the errors (8a) and (8b) of the velocity, as in Table 4; "
            "$E_x$ is the largest error of the position.",
        ),
        *(_errors(study, name, group) for name, group in slow.groupby("motion", sort=False)),
        _limits(slow),
        *_sensitivity(study.sensitivity),
        *_weak(study, slow, reproduction.truth),
    )


def _name(row: Mapping[Hashable, object]) -> str:
    region = str(row["region"]).replace("um", "µm")
    return f"{str(row['motion']).capitalize()}, {region}, {SHOWN[str(row['metric'])]}"


def _errors(study: MotionStudy, motion: Hashable, frame: pd.DataFrame) -> Html:
    """Return the table of one motion: each error of the measured motion, and of the true one."""
    rows = [
        (
            _name(row),
            row["velocity"],
            row["unit"].replace("um", "µm"),
            *(f"{row[name]:.3f}" for name in study.names),
            percent(reduction(row[UNCOMPENSATED], row[LEARNED])),
        )
        for _, errors in frame.groupby(["region", "metric"], sort=False)
        for row in errors.to_dict("records")
    ]
    head = ("", "", "Unit", *(STEPS[name] for name in study.names), "Reduction")
    caption = (
        f"{str(motion).capitalize()}: tracking errors of the simulated drive; the reduction (9) is "
        f"that of the column “{STEPS[LEARNED]}”"
    )
    return table(head, rows, caption, (0, 1, 2))


def _limits(slow: pd.DataFrame) -> Html:
    """Return where compensation gains little, and where it makes the error larger."""
    left = slow[LEARNED] / slow[UNCOMPENSATED]
    worse, little = (
        "; ".join(
            f"{_name(row)}, {row['velocity']} ({percent(row[LEARNED] / row[UNCOMPENSATED], 0)})"
            for row in slow[found].to_dict("records")
        )
        for found in (left > 1.0, (left > 0.5) & (left <= 1.0))
    )
    text = "The learned compensator makes none of these errors larger. "
    if worse:
        text = f"The learned compensator makes these errors larger: {worse}. "
    if little:
        text += f"It leaves more than half of these: {little}. "
    text += (
        "The true velocity holds the loop’s response to each encoder step as well, which no "
        "compensator removes."
    )
    if IDENTIFIED in slow:
        change = slow[LEARNED] / slow[IDENTIFIED]
        text += (
            f" Of these {len(slow)} errors, those of the learned compensator are larger than those "
            f"of the identified one by more than a tenth in {int((change > 1.1).sum())}, and "
            f"smaller by more than a tenth in {int((change < 0.9).sum())}."
        )
    return paragraph(text)


def _sensitivity(shown: pd.DataFrame) -> tuple[Html, Html, Html]:
    lost = by_motion(shown)
    rows = [
        (_wrong(key), *(f"{100.0 * value:.1f}".replace("-", "−") for value in lost.loc[key]))
        for key in lost.index
    ]
    trapezoid, others = (
        ", ".join(_wrong(key) for key in unseen(part)) or "nothing"
        for part in (lost[[TRAPEZOID.name]], lost.drop(columns=TRAPEZOID.name))
    )
    return (
        paragraph(
            "What a motion shows of a parameter is what an otherwise exact compensator loses when "
            "that parameter is wrong: percentage points by which the reduction (9) of $E_{rms}$ or "
            "$E_x$ falls, on the drive’s true motion and in the region where it falls most. "
            f"{percent(SEEN, 0)} or more counts as seen. The last row is a change too small to "
            "matter; what it costs is chance, because the encoder’s steps fall elsewhere.",
        ),
        table(
            ("Wrong parameter", *(str(name).capitalize() for name in lost.columns)),
            rows,
            "Percentage points of the reduction that one wrong parameter costs",
        ),
        paragraph(
            f"The trapezoid alone does not see: {trapezoid}. What none of the three slow motions "
            f"sees: {others}."
        ),
    )


def _wrong(key: tuple[str, str]) -> str:
    name, change = key
    return f"{symbol(name)} {change.replace('x', '×').replace('F_c', symbol('F_c'))}"


def _weak(study: MotionStudy, slow: pd.DataFrame, truth: Mapping[str, float]) -> tuple[Html, Html]:
    """Return what an exact compensator does to creep in a weak loop."""
    names = UNCOMPENSATED, LEARNED, *WEAK_ENTRIES
    creep = slow[(slow["motion"] == CREEP.name) & (slow["velocity"] == "true")]
    creep = creep[creep["metric"] == "E_rms"]
    without, exact = (creep[name] for name in WEAK_ENTRIES)
    worse = ", ".join(creep["region"][exact > without]) or "none of these speeds"
    falls = "Where friction falls with speed"
    F_s, F_c, v_s = (truth.get(name, math.nan) for name in ("F_s", "F_c", "v_s"))
    if math.isfinite((F_s - F_c) / v_s):
        steepest = number((F_s - F_c) / v_s)
        falls += f", at most by ($F_s$ − $F_c$)/$v_s$ = {steepest} N s/m on this drive"
    rows = [
        (f"Creep, {row['region']}", *(f"{row[name]:.3f}" for name in names))
        for row in creep.to_dict("records")
    ]
    return (
        paragraph(
            f"Feedforward does not damp. {falls}, it is the loop that must hold the velocity. In a "
            f"loop with a tenth of the bandwidth ($K_p$ = {number(study.weak.K_p)} N s/m) an exact "
            f"compensator makes creep worse at {worse}."
        ),
        table(
            ("", *(name.capitalize() for name in names)),
            rows,
            "RMS error of the true velocity in creep [mm/s], in the loop of this page and in a "
            "weak one",
        ),
    )
