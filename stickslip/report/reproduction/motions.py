"""The slow motions, and the steps compared on Table 4."""

from __future__ import annotations

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
from stickslip.report.markup import (
    METRICS,
    Html,
    element,
    join,
    paragraph,
    parameter,
    symbol,
    table,
)
from stickslip.report.page import Illustration, Section
from stickslip.report.quantity import number, percent
from stickslip.report.reproduction.curves import draw_motions, draw_steps
from stickslip.servo.datasheet import REGION, VALIDATION
from stickslip.servo.tuned_pi import peak_sensitivity

TRAPEZOID, CREEP = MOTIONS[0], SLOW_MOTIONS[1]
SHOWN = METRICS | {"E_x": symbol("E", "x")}
UNITS = {"mm/s": "mm/s", "um": "µm"}


def motions_section(reproduction: Reproduction) -> Section | None:
    """Return the section on the other motions, None where they were not run."""
    study = reproduction.motions
    if study is None:
        return None
    slowest, fastest = (1e3 * VALIDATION.slope * edge for edge in REGION)
    frame = study.evaluation.table()
    slow = frame[frame["motion"] != TRAPEZOID.name]
    return Section(
        "Slow reversals, creep and micrometre moves",
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
        Illustration(
            "motions",
            partial(draw_motions, reproduction),
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
            _motion_errors(study, motion.name, slow[slow["motion"] == motion.name])
            for motion in SLOW_MOTIONS
        ),
        _limits(slow),
        _sensitivity(study.sensitivity),
        _weak(study, slow, reproduction.truth),
    )


def _name(row: Mapping[Hashable, object]) -> Html:
    region = str(row["region"]).replace("um", "µm")
    return join([f"{str(row['motion']).capitalize()}, {region}, ", SHOWN[str(row["metric"])]])


def _motion_errors(study: MotionStudy, motion: str, frame: pd.DataFrame) -> Html:
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


SCATTER = 0.02
"""Relative change of an error below which a step is sentences to have changed nothing."""


def steps_section(reproduction: Reproduction) -> Section | None:
    """Return the section, None where the steps were not compared."""
    if reproduction.motions is None:
        return None
    own = _renamed(reproduction.table4())
    parts: list[Html | Illustration] = [
        paragraph(
            "The same drive, controlled step by step: the paper’s loop without compensation "
            "(none); a PI controller alone, its gains tuned against friction at the same peak "
            "sensitivity; a compensator with the identified parameters; one learned as published "
            "from coarse starts (median over seeds); the default from some of these starts "
            "(coarse); the default, which begins at the identified parameters; one learned from a "
            "single recording; and the same with velocity filter and feedforward of inertia (and "
            "filter).",
        ),
        Illustration(
            "steps",
            partial(draw_steps, reproduction),
            "Errors of Table 4 on the true velocity, step by step",
            "Errors (8a), (8b) on the drive’s true velocity. The shaded bands are the range of the "
            "real stage’s four errors (paper), which were measured.",
        ),
        _step_errors(own, "Table 4, step by step: the simulated drive [mm/s]"),
        _pi(reproduction),
        _learning(own, "the simulated drive"),
    ]
    extras = reproduction.extras
    if extras and extras.table4 is not None:
        table4 = _renamed(extras.table4)
        parts += [
            _step_errors(
                table4, "Table 4, step by step: the simulated drive, all extras on [mm/s]"
            ),
            _learning(table4, "the drive with all extras on"),
        ]
    return Section("Comparison of the steps", *parts)


def _renamed(table4: pd.DataFrame) -> pd.DataFrame:
    return table4.rename(columns={"with": LEARNED})


def _step_errors(table4: pd.DataFrame, caption: str) -> Html:
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
    sentences = []
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
        sentences.append(f"{STEPS[name].lower()} {verdict}")
    found = "; ".join(sentences).replace("-", "−")
    return paragraph(
        f"Against identification alone, on the true velocity of {drive}: {found}.",
    )
