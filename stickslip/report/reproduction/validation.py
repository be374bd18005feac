"""Section 4.2 of the paper, Table 4 and Fig. 6, and Table 4 step by step."""

from __future__ import annotations

from functools import partial

import pandas as pd

from stickslip.evaluation.motion_study import LEARNED
from stickslip.evaluation.validation import Validation
from stickslip.pipeline.reproduction import Reproduction
from stickslip.pipeline.steps import STEPS
from stickslip.report.markup import Html, paragraph, table
from stickslip.report.page import Illustration, Section
from stickslip.report.quantity import METRICS, number, percent
from stickslip.report.reproduction.curves import draw_steps, draw_tracking
from stickslip.servo.datasheet import REGION, VALIDATION
from stickslip.servo.measurement import CUTOFF
from stickslip.servo.tuned_pi import peak_sensitivity


def validation_section(validation: Validation) -> Section:
    """Return the section on validation."""
    begin, end = (number(1e3 * edge) for edge in REGION)
    return Section(
        "Validation",
        paragraph(
            "The simulated drive follows a trapezoid of "
            f"±{number(1e3 * VALIDATION.height)} mm/s with ramps of "
            f"{number(VALIDATION.slope)} m/s², which the learning never saw. Errors (8a), (8b) are "
            f"taken against the command from {begin} to {end} ms after the motion starts or "
            "reverses. “Measured” is the encoder’s position, differenced and low-passed at "
            f"{number(CUTOFF)} Hz without phase lag; “true” is the drive’s own velocity, which "
            "no experimenter sees, and which shows the loop’s answer to every encoder step."
        ),
        table(
            ("", "", "Without [mm/s]", "With [mm/s]", "Reduction"),
            _rows(validation.table()),
            "Table 4. Tracking errors of the simulated drive, calibrated to “Without”, measured, "
            "of the real stage (paper)",
            (0, 1),
        ),
        paragraph(
            "The paper prints no unit; mm/s is the reading that fits. It gives neither gains nor "
            "ramps, windows or filters either. They were searched so that the errors of the "
            "simulated drive with the paper’s parameters, without compensation and as measured, "
            "come near those of the real stage. That these agree is therefore no evidence."
        ),
        Illustration(
            "fig6_tracking",
            partial(draw_tracking, validation),
            "Velocity and velocity error of the simulated drive at motion start and reversal, "
            "without and with compensation",
            "Fig. 6. The simulated drive. (a) The command and the measured velocity with "
            "compensation. (b), (c) Velocity and error $v_{cmd}$ − $v$ where the motion starts and "
            "reverses: measured velocity as a thick line, true velocity as a thin one. Table 4 "
            "evaluates the shaded window.",
        ),
    )


def _rows(frame: pd.DataFrame) -> list[tuple[str, ...]]:
    """Return each error of the simulated drive, measured and true, and then the real stage's."""
    rows: list[tuple[str, ...]] = []
    for (region, metric), errors in frame.groupby(["region", "metric"], sort=False):
        name = f"Motion {region}, {METRICS[str(metric)]}"
        for row in errors.to_dict("records"):
            label = f"simulated drive, {row['velocity']}"
            numbers = f"{row['without']:.3f}", f"{row['with']:.3f}", percent(row["reduction"])
            rows.append((name, label, *numbers))
        paper = f"{row['paper_without']:.2f}", f"{row['paper_with']:.2f}"
        rows.append((name, "real stage (paper)", *paper, percent(row["paper_reduction"], 0)))
    return rows


SCATTER = 0.02
"""Relative change of an error below which a step counts as having changed nothing."""


def steps_section(reproduction: Reproduction) -> Section | None:
    """Return the section, None where the steps were not compared."""
    if reproduction.motions is None:
        return None
    tuned, loop = reproduction.motions.loops["tuned_pi"], reproduction.identification.loop
    extras = reproduction.extras
    return Section(
        "Comparison of the steps",
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
        _step_errors(reproduction.table4(), "the simulated drive"),
        paragraph(
            f"The tuned PI controller has $K_p$ = {number(tuned.K_p)} N s/m and $K_i$ = "
            f"{number(tuned.K_i)} N/m instead of {number(loop.K_p)} and {number(loop.K_i)}, at a "
            f"peak sensitivity of {number(peak_sensitivity(loop), 3)} in both. The windows of "
            "Table 4 begin 30 ms after the reversal, when much integral gain has already pushed "
            "through most of the friction: a comparison with a softly tuned loop flatters every "
            "compensator.",
        ),
        _benefit(reproduction.table4(), "the simulated drive"),
        *(
            part(extras.table4, drive)
            for part, drive in (
                (_step_errors, "the simulated drive, all extras on"),
                (_benefit, "the drive with all extras on"),
            )
            if extras and extras.table4 is not None
        ),
    )


def _step_errors(table4: pd.DataFrame, drive: str) -> Html:
    table4 = table4.rename(columns={"with": LEARNED})
    names = [name for name in STEPS if name in table4]
    rows = [
        (
            f"{row['region'].capitalize()}, {METRICS[row['metric']]}",
            row["velocity"],
            *(f"{row[name]:.3f}" for name in names),
        )
        for row in table4.to_dict("records")
    ]
    caption = f"Table 4, step by step: {drive} [mm/s]"
    return table(("", "", *(STEPS[name] for name in names)), rows, caption, (0, 1))


def _benefit(table4: pd.DataFrame, drive: str) -> Html:
    """Return whether learning did better than identification, on the true velocity."""
    table4 = table4.rename(columns={"with": LEARNED})
    true = table4[(table4["velocity"] == "true") & (table4["metric"] == "E_rms")]
    sentences = []
    for name in ("as_published", "coarse_default", LEARNED, "one_recording"):
        if name not in true:
            continue
        change = true[name] / true["identified"] - 1.0
        verdict = "changed nothing"
        if not (change.abs() < SCATTER).all():
            verdict = "changed the RMS error by " + ", ".join(
                f"{'+' * (value > 0)}{percent(value, 0)} at the {region}"
                for value, region in zip(change, true["region"], strict=True)
            )
        sentences.append(f"{STEPS[name].lower()} {verdict}")
    return paragraph(
        f"Against identification alone, on the true velocity of {drive}: {'; '.join(sentences)}.",
    )
