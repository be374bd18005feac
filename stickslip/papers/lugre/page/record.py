"""Sections of record mode: validation, the parts of the loop, and the search."""

from __future__ import annotations

from functools import partial

from stickslip.papers.lugre.page.curves import draw_course
from stickslip.papers.lugre.page.diagrams import draw_loops
from stickslip.papers.lugre.page.validation import validation_section
from stickslip.papers.lugre.record_mode import RecordReproduction
from stickslip.presentation.markup import paragraph, table
from stickslip.presentation.page import Illustration, Section

FIGURES = ("fig2_loops", "fig5_fitness", "fig6_tracking")
COST = r"$\sum (F - F_{predicted})^2$ [N$^2$]"


def sections(reproduction: RecordReproduction) -> list[Section]:
    """Return the sections on the loop that was designed on the learned parameters."""
    return [
        validation_section(reproduction.validation),
        _attribution(reproduction),
        _loops(reproduction),
    ]


def _attribution(reproduction: RecordReproduction) -> Section:
    frame = reproduction.attribution
    metrics = [name for name in frame.columns if name.endswith(("E_max", "E_rms"))]
    rows = [
        (
            *("on" if row[part] else "off" for part in ("compensator", "filter", "inertia")),
            row["velocity"],
            *(f"{row[metric]:.3f}" for metric in metrics),
        )
        for row in frame.to_dict("records")
    ]
    head = ("Compensator", "Velocity filter", "Feedforward of inertia", "Velocity", *metrics)
    return Section(
        "Contribution of each part",
        paragraph(
            "Table 4 compares, on the simulated drive, the paper’s loop without compensation with "
            "the loop that has all three: the learned compensator, a Kalman filter of encoder and "
            "motor force, and feedforward of inertia, which need the learned mass. A velocity "
            "filter that is designed for a compensated drive tracks worse without one, so the "
            "plain loop is the fair comparison; this table has all eight combinations."
        ),
        table(
            head,
            rows,
            "Tracking errors of the simulated drive in mm/s, by what is on",
            (0, 1, 2, 3),
        ),
    )


def _loops(reproduction: RecordReproduction) -> Section:
    options, loop = reproduction.options, reproduction.learned.designed.plain
    algorithm = reproduction.learned.estimation.searches.algorithm
    return Section(
        "The loops and the search",
        paragraph(
            "The simulated drive was recorded once, for 20 s, in a soft loop without compensation "
            "that was designed on its nominal mass. The loop of the paper was then designed on the "
            "mass and viscous friction that the recording gave."
        ),
        Illustration(
            "fig2_loops",
            partial(draw_loops, loop, reproduction.truth, options),
            "Block diagrams of the compensated and the nominal loop, and its step response",
            "The loops; the velocity filter, which takes the place of the velocity estimate, is "
            "not drawn.",
        ),
        Illustration(
            "fig5_fitness",
            partial(draw_course, algorithm, COST),
            "Cost over the generations of the search",
            f"The global search: {algorithm.stopped}. The fit that follows it has no generations.",
        ),
    )
