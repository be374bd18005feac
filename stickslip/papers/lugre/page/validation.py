"""Section 4.2 of the paper, Table 4 step by step, and the slow motions."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from functools import partial

import pandas as pd

from stickslip.evaluation.motions import REGION, SLOW_MOTIONS, VALIDATION
from stickslip.evaluation.validation import PHASES, Validation, reduction
from stickslip.papers.lugre.page.curves import draw_motions, draw_steps, draw_tracking
from stickslip.papers.lugre.reproduction import Extras, Reproduction
from stickslip.papers.lugre.steps import (
    FILTERED,
    LEARNED,
    REDUCTION_WITH_FILTER,
    STEPS,
    TRAPEZOID,
    UNCOMPENSATED,
    by_step,
)
from stickslip.presentation.markup import Html, element, join, paragraph, quiet, table
from stickslip.presentation.page import Illustration, Section
from stickslip.presentation.quantity import METRICS, number, percent, ranged
from stickslip.servo.measurement import CUTOFF
from stickslip.servo.sensitivity import peak_sensitivity
from stickslip.servo.tuned_pi import tuned_pi


def validation_section(validation: Validation, table4: pd.DataFrame | None = None) -> Section:
    """Return the section on validation.

    Parameters
    ----------
    table4 : with the columns of the velocity filter, where it was tried
    """
    errors = validation.table() if table4 is None else table4
    begin, end = (number(1e3 * edge) for edge in REGION)
    return Section(
        "Validation",
        paragraph(
            f"The simulated drive follows a trapezoid of ±{number(1e3 * VALIDATION.height)} mm/s "
            f"with ramps of {number(VALIDATION.slope)} m/s², which learning does not use. Errors "
            f"(8a), (8b) are taken against the command from {begin} to {end} ms after the motion "
            "starts or reverses. “Measured” is the encoder’s position, differenced and low-passed "
            f"at {number(CUTOFF)} Hz without phase lag; “true” is the drive’s own velocity, which "
            "cannot be measured, and which contains the loop’s response to every encoder step. "
            f"{PHASED}"
        ),
        table(
            ("", "", "Without [mm/s]", "With [mm/s]", "Reduction"),
            _rows(errors),
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
        *([FILTER] if FILTERED in errors else []),
        Illustration(
            "fig6_tracking",
            partial(draw_tracking, validation),
            "Velocity and velocity error of the simulated drive at motion start and reversal, "
            "without and with compensation",
            "The simulated drive, as Fig. 6 of the paper. (a) The command and the measured "
            "velocity with compensation. (b), (c) Velocity and error $v_{cmd}$ − $v$ where the "
            "motion starts and reverses: measured velocity as a thick line, true velocity as a "
            "thin one. Table 4 evaluates the shaded window.",
        ),
    )


PHASED = (
    "How the encoder’s steps fall is chance. Each error is therefore the median of runs that begin "
    f"at {len(PHASES)} phases of an encoder step, with other noise, and below it stands the range."
)
FILTER = paragraph(
    "What feedforward alone leaves of the true velocity is mainly the loop’s response to single "
    "encoder steps: differentiated over a sample, a step is a velocity of its own, and $K_p$ "
    "makes a pulse of force of it. The rows “velocity filter” have the same gains and the same "
    "compensator; the velocity comes from a Kalman filter of encoder and motor force, and the "
    "force that accelerates the mass is fed forward. Their reduction is against the loop without "
    "compensation and without filter."
)


def _rows(frame: pd.DataFrame) -> list[tuple[str, ...]]:
    """Return each error of the simulated drive, measured and true, and then the real stage's."""
    rows: list[tuple[str, ...]] = []
    for (region, metric), errors in frame.groupby(["region", "metric"], sort=False):
        name = f"Motion {region}, {METRICS[str(metric)]}"
        for row in errors.to_dict("records"):
            label = f"simulated drive, {row['velocity']}"
            numbers = ranged(row, "without"), ranged(row, "with"), ranged(row, "reduction", percent)
            rows.append((name, label, *numbers))
            if FILTERED in row:
                reduced = ranged(row, REDUCTION_WITH_FILTER, percent)
                numbers = numbers[0], ranged(row, FILTERED), reduced
                rows.append((name, f"{label}, velocity filter", *numbers))
        paper = f"{row['paper_without']:.2f}", f"{row['paper_with']:.2f}"
        rows.append((name, "real stage (paper)", *paper, percent(row["paper_reduction"], 0)))
    return rows


def steps_section(reproduction: Reproduction) -> Section | None:
    """Return the section, None where the steps were not compared."""
    if reproduction.motions is None:
        return None
    loop = reproduction.identification.loop
    tuned = tuned_pi(loop)
    return Section(
        "Comparison of the steps",
        paragraph(
            "The same drive, controlled step by step: the paper’s loop without compensation "
            "(none); a PI controller alone, its gains tuned against friction at the same peak "
            "sensitivity; a compensator with the identified parameters; one learned as published "
            "and one by least squares from coarse starts (over seeds); the default, which begins "
            "at the identified parameters; one learned from a single recording; and the last two "
            "with velocity filter and feedforward of inertia, which the paper does not have "
            "(filter).",
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
            "through most of the friction: a comparison with a softly tuned loop favours every "
            "compensator.",
        ),
        _extras(reproduction.extras),
    )


def _extras(extras: Extras | None) -> Html:
    """Return the same of the drive with every effect of its model, or why there is nothing."""
    if extras is None:
        return Html("")
    if extras.table4 is None:
        return paragraph(f"With all extras on the drive could not be learned: {extras.reason}.")
    return join(
        [
            _step_errors(extras.table4, "the simulated drive, all extras on"),
            quiet(
                "“All extras on” is the same drive with every effect of its model: identified, "
                "learned and validated from the beginning, with the same settings.",
            ),
        ]
    )


def _step_errors(table4: pd.DataFrame, drive: str) -> Html:
    table4 = by_step(table4)
    names = [name for name in STEPS if name in table4]
    rows = [
        (
            f"{row['region'].capitalize()}, {METRICS[row['metric']]}",
            row["velocity"],
            *(ranged(row, name) for name in names),
        )
        for row in table4.to_dict("records")
    ]
    caption = f"Table 4, step by step: {drive} [mm/s]"
    return table(("", "", *(STEPS[name] for name in names)), rows, caption, (0, 1))


SHOWN = METRICS | {"E_x": "$E_x$"}


def motions_section(reproduction: Reproduction) -> Section | None:
    """Return the section on the other motions, None where they were not run."""
    evaluation = reproduction.motions
    if evaluation is None:
        return None
    slowest, fastest = (1e3 * VALIDATION.slope * edge for edge in REGION)
    frame = evaluation.table()
    slow = frame[frame["motion"] != TRAPEZOID.name]
    names = [name for name in STEPS if name in evaluation.runs[TRAPEZOID.name]]
    purposes = (
        element("li", element("b", motion.name.capitalize()), f". {motion.purpose}")
        for motion in SLOW_MOTIONS
    )
    return Section(
        "Slow reversals, creep and micrometre moves",
        paragraph(
            f"The errors of Table 4 are taken at speeds of {number(slowest, 2)} to "
            f"{number(fastest, 2)} mm/s, where friction with the paper’s parameters is close to "
            "$F_c$; the other four hardly change them. Three more motions, which learning does not "
            "use, are slower or shorter:",
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
            f"$E_x$ is the largest error of the position. Medians over {len(PHASES)} phases of an "
            "encoder step, with their ranges.",
        ),
        *(_errors(names, motion, group) for motion, group in slow.groupby("motion", sort=False)),
        _limits(slow),
    )


def _errors(names: Sequence[str], motion: Hashable, frame: pd.DataFrame) -> Html:
    """Return the table of one motion: each error of the measured motion, and of the true one."""
    rows = [
        (
            _error_name(row),
            row["velocity"],
            row["unit"].replace("um", "µm"),
            *(ranged(row, name) for name in names),
            percent(reduction(row[UNCOMPENSATED], row[LEARNED])),
        )
        for _, errors in frame.groupby(["region", "metric"], sort=False)
        for row in errors.to_dict("records")
    ]
    head = ("", "", "Unit", *(STEPS[name] for name in names), "Reduction")
    caption = (
        f"{str(motion).capitalize()}: tracking errors of the simulated drive; the reduction (9) is "
        f"that of the column “{STEPS[LEARNED]}”"
    )
    return table(head, rows, caption, (0, 1, 2))


def _limits(slow: pd.DataFrame) -> Html:
    """Return where compensation gains little, and where it makes the error larger."""
    left = slow[LEARNED] / slow[UNCOMPENSATED]
    worse = [
        f"{_error_name(row)}, {row['velocity']} ({percent(share, 0)})"
        for row, share in zip(slow.to_dict("records"), left, strict=True)
        if share > 1.0
    ]
    text = "none of these errors larger"
    if worse:
        text = f"these errors larger: {'; '.join(worse)}"
    return paragraph(
        f"The learned compensator makes {text}. It leaves more than half of "
        f"{int((left > 0.5).sum())} of these {len(slow)} errors. The true velocity holds the "
        "loop’s response to each encoder step as well, which no compensator removes. Feedforward "
        "adds no damping either: where friction falls with speed, the loop alone must stabilise "
        "the velocity, and in a soft loop an exact compensator can make creep worse."
    )


def _error_name(row: Mapping[Hashable, object]) -> str:
    """Return what an error of ``Evaluation.table`` is of."""
    region = str(row["region"]).replace(" um", " µm")
    return f"{str(row['motion']).capitalize()}, {region}, {SHOWN[str(row['metric'])]}"
