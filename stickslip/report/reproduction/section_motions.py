"""Motions that show what the trapezoid does not, and where compensation does not help."""

from __future__ import annotations

from collections.abc import Hashable, Mapping

import pandas as pd

from stickslip.evaluation.motion_study import (
    IDENTIFIED,
    LEARNED,
    UNCOMPENSATED,
    WEAK_ENTRIES,
    MotionStudy,
)
from stickslip.evaluation.motions import MOTIONS, SLOW_MOTIONS
from stickslip.evaluation.sensitivity import (
    SEEN,
    by_motion,
    unseen,
)
from stickslip.evaluation.validation import reduction
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
from stickslip.report.shown import (
    METRICS,
    figure,
    parameter,
)
from stickslip.servo.datasheet import REGION, VALIDATION

TRAPEZOID, CREEP = MOTIONS[0], SLOW_MOTIONS[1]
SHOWN = METRICS | {"E_x": symbol("E", "x")}
UNITS = {"mm/s": "mm/s", "um": "µm"}


def write(reproduction: Reproduction, pictures: Mapping[str, Picture]) -> Html:
    """Return the section on the other motions, nothing where they were not run."""
    study = reproduction.motions
    if study is None:
        return Html()
    slowest, fastest = (1e3 * VALIDATION.slope * edge for edge in REGION)
    frame = study.evaluation.table()
    slow = frame[frame["motion"] != TRAPEZOID.name]
    return element(
        "section",
        element("h2", "Slow reversals, creep and micrometre moves"),
        paragraph(
            f"The errors of Table 4 are taken at speeds of {number(slowest, 2)} to "
            f"{number(fastest, 2)} mm/s, where friction with the paper’s parameters is close to ",
            symbol("F", "c"),
            "; the other four hardly change them. Three more motions, which the learning never "
            "saw, are slower or shorter:",
        ),
        element(
            "ul",
            join(
                (
                    element("li", element("b", motion.name.capitalize()), f". {motion.purpose}")
                    for motion in SLOW_MOTIONS
                ),
                "\n",
            ),
        ),
        figure(
            pictures["motions"],
            "Velocity or position against time in the three motions, without and with compensation",
            "The simulated drive in the three motions: command, measured motion without "
            "compensation and with the learned compensator.",
        ),
        paragraph(
            SHOWN["E_max"],
            " and ",
            SHOWN["E_rms"],
            " are the errors (8a) and (8b) of the velocity, as in Table 4; ",
            SHOWN["E_x"],
            " is the largest error of the position.",
        ),
        *(
            _errors(study, motion.name, slow[slow["motion"] == motion.name])
            for motion in SLOW_MOTIONS
        ),
        _limits(slow),
        _sensitivity(study.sensitivity),
        _weak(study, slow, reproduction.truth),
    )


def _name(row: Mapping[Hashable, object]) -> Html:
    region = str(row["region"]).replace("um", "µm")
    return join([f"{str(row['motion']).capitalize()}, {region}, ", SHOWN[str(row["metric"])]])


def _errors(study: MotionStudy, motion: str, frame: pd.DataFrame) -> Html:
    """Return the table of one motion: each error of the measured motion, and of the true one."""
    groups = frame.groupby(["region", "metric"], sort=False)
    rows = [
        (
            _name(row),
            row["velocity"],
            UNITS[row["unit"]],
            *(f"{row[name]:.3f}" for name in study.names),
            percent(reduction(row[UNCOMPENSATED], row[LEARNED])),
        )
        for _, errors in groups
        for row in errors.to_dict("records")
    ]
    head = ("", "", "Unit", *(STEPS[name] for name in study.names), "Reduction")
    caption = (
        f"{motion.capitalize()}: tracking errors of the simulated drive; the reduction (9) is that "
        f"of the column “{STEPS[LEARNED]}”"
    )
    return table(head, rows, caption, (0, 1, 2))


def _limits(slow: pd.DataFrame) -> Html:
    """Return where compensation gains little, and where it makes the error larger."""
    left = slow[LEARNED] / slow[UNCOMPENSATED]
    worse, little = (
        [
            join(
                [
                    _name(row),
                    f", {row['velocity']} ({percent(row[LEARNED] / row[UNCOMPENSATED], 0)})",
                ]
            )
            for row in slow[found].to_dict("records")
        ]
        for found in (left > 1.0, (left > 0.5) & (left <= 1.0))
    )
    return paragraph(
        *_list("The learned compensator makes these errors larger: ", worse)
        or ("The learned compensator makes none of these errors larger. ",),
        *_list("It leaves more than half of these: ", little),
        "The true velocity holds the loop’s response to each encoder step as well, which no "
        "compensator removes.",
        *(_against_identified(slow) if IDENTIFIED in slow else ()),
    )


def _against_identified(slow: pd.DataFrame) -> tuple[str, ...]:
    """Return what learning brought beyond the parameters that it began with."""
    change = slow[LEARNED] / slow[IDENTIFIED]
    return (
        f" Of these {len(slow)} errors, those of the learned compensator are larger than those of "
        f"the identified one by more than a tenth in {int((change > 1.1).sum())}, and smaller by "
        f"more than a tenth in {int((change < 0.9).sum())}.",
    )


def _list(begins: str, items: list[Html]) -> tuple[str, ...]:
    return (begins, join(items, "; "), ". ") if items else ()


def _sensitivity(shown: pd.DataFrame) -> Html:
    lost = by_motion(shown)
    rows = [
        (_wrong(key), *(f"{100.0 * value:.1f}".replace("-", "−") for value in lost.loc[key]))
        for key in lost.index
    ]
    return join(
        [
            paragraph(
                "What a motion shows of a parameter is what an otherwise exact compensator loses "
                "when that parameter is wrong: percentage points by which the reduction (9) of ",
                SHOWN["E_rms"],
                " or ",
                SHOWN["E_x"],
                " falls, on the drive’s true motion and in the region where it falls most. ",
                percent(SEEN, 0),
                " or more counts as seen. The last row is a change too small to matter; what it "
                "costs is chance, because the encoder’s steps fall elsewhere.",
            ),
            table(
                ("Wrong parameter", *(str(name).capitalize() for name in lost.columns)),
                rows,
                "Percentage points of the reduction that one wrong parameter costs",
            ),
            paragraph(
                "The trapezoid alone does not see: ",
                _missed(lost[[TRAPEZOID.name]]),
                ". What none of the three slow motions sees: ",
                _missed(lost.drop(columns=TRAPEZOID.name)),
                ".",
            ),
        ]
    )


def _wrong(key: tuple[str, str]) -> Html:
    name, change = key
    if change == "= F_c":
        return join([parameter(name), " = ", parameter("F_c")])
    return join([parameter(name), f" {change.replace('x', '×')}"])


def _missed(lost: pd.DataFrame) -> Html:
    """Return the wrong parameters that cost less than counts as seen."""
    return join([_wrong(key) for key in unseen(lost)], ", ") or Html("nothing")


def _weak(study: MotionStudy, slow: pd.DataFrame, truth: Mapping[str, float]) -> Html:
    """Return what an exact compensator does to creep in a weak loop."""
    names = UNCOMPENSATED, LEARNED, *WEAK_ENTRIES
    creep = slow[(slow["motion"] == CREEP.name) & (slow["velocity"] == "true")]
    creep = creep[creep["metric"] == "E_rms"]
    without, exact = (creep[name] for name in WEAK_ENTRIES)
    worse = list(creep["region"][exact > without])
    falls = (truth["F_s"] - truth["F_c"]) / truth["v_s"]
    rows = [
        (f"Creep, {row['region']}", *(f"{row[name]:.3f}" for name in names))
        for row in creep.to_dict("records")
    ]
    return join(
        [
            paragraph(
                "Feedforward does not damp. Where friction falls with speed, at most by (",
                parameter("F_s"),
                " − ",
                parameter("F_c"),
                ")/",
                parameter("v_s"),
                f" = {number(falls)} N s/m on this drive, it is the loop that must hold the "
                "velocity. In a loop with a tenth of the bandwidth (",
                symbol("K", "p"),
                f" = {number(study.weak.K_p)} N s/m) an exact compensator makes creep "
                + (f"worse at {', '.join(worse)}." if worse else "worse at none of these speeds."),
            ),
            table(
                ("", *(name.capitalize() for name in names)),
                rows,
                "RMS error of the true velocity in creep [mm/s], in the loop of this page and in a "
                "weak one",
            ),
        ]
    )
