"""The pages of a reproduction: drive mode, record mode, and the learning as published."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from stickslip.catalog.parameters import LUGRE, friction_law
from stickslip.evaluation import motions
from stickslip.evaluation.motions import SLOW_MOTIONS
from stickslip.evaluation.validation import PHASES, Validation
from stickslip.identification.stages import friction_map, inertia
from stickslip.papers.lugre import tables
from stickslip.papers.lugre.loop_tuning import FRICTION
from stickslip.papers.lugre.page import curves
from stickslip.papers.lugre.published import PAPER_COST, SQUARES, PublishedStudy
from stickslip.papers.lugre.reproduction import BaseResult, Reproduction
from stickslip.papers.lugre.steps import FILTERED, LEARNED, STEPS, TRAPEZOID, UNCOMPENSATED
from stickslip.presentation.page import Section, picture_files, write_page
from stickslip.presentation.quantity import METRICS, percent
from stickslip.servo.axis import LOOP
from stickslip.servo.measurement import CUTOFF
from stickslip.servo.sensitivity import peak_sensitivity
from stickslip.servo.tuned_pi import tuned_pi
from stickslip.thresholds import kept
from stickslip.tuning import loop_learning, search
from stickslip.tuning.drive_model import PROBES
from stickslip.tuning.learning import SPREAD
from stickslip.tuning.loop_runs import training_motion

TITLE = "Friction compensator of a linear motor, learned"
FIG5 = "fig5_as_published"  # Name of the figure of the learning as published
FIGURES = (
    "loop_tuning",
    *("fig5_fitness", "fig6_tracking", "steps", "motions"),
    *("identification_inertia", "identification_friction", "identification_presliding"),
)
FILES = ("report.html", *picture_files(FIGURES))  # What ``write_report`` writes


def section(
    title: str,
    template: str,
    of: BaseResult | None = None,
    figures: Mapping[str, Callable[[], Figure]] | None = None,
    **values: object,
) -> Section:
    """Return the section of a template beside this file, which has the numbers of the paper."""
    return Section(
        title,
        f"papers/lugre/page/{template}.j2",
        figures,
        reproduction=of,
        tables=tables,
        paper=motions,
        LOOP=LOOP,
        PHASES=PHASES,
        PAPER_COST=PAPER_COST,
        **values,
    )


def sections(reproduction: Reproduction) -> Sequence[Section]:
    """Return the sections of the page."""
    loop = reproduction.identification.loop
    experiments = {
        "identification_inertia": partial(curves.draw_inertia, reproduction),
        "identification_friction": partial(curves.draw_friction, reproduction),
        "identification_presliding": partial(curves.draw_presliding, reproduction),
    }
    of_stages = {"sliding": friction_map, "inertia": inertia}
    steps = {"steps": partial(curves.draw_steps, reproduction)}
    loops = {"own": loop, "tuned": tuned_pi(loop), "peak": peak_sensitivity(loop)}
    return [
        _head(reproduction),
        section("The loop", "loop", reproduction),
        section("Identification", "identification", reproduction, experiments, **of_stages),
        section("Learning the friction", "learning", reproduction),
        _loop_learning(reproduction),
        validation_section(reproduction.validation, reproduction.table4()),
        section("Comparison of the steps", "steps", reproduction, steps, **loops),
        _motions(reproduction, reproduction.motions.table()),
        section("Using the results", "use", reproduction),
    ]


def _head(reproduction: Reproduction) -> Section:
    """Return what was done, what each step brings, and the verdict."""
    table, loops = reproduction.table4(), reproduction.loops
    own = table[table["velocity"] == "measured"]
    found = [
        (
            f"Motion {row['region']}, {METRICS[row['metric']]}",
            percent(row["reduction"]),
            f"real stage (paper) {percent(row['paper_reduction'], 0)}",
        )
        for row in own.to_dict("records")
    ]
    return section(
        "",
        "result",
        reproduction,
        {"loop_tuning": partial(curves.draw_stages, loops)},
        FRICTION=[f"{level:g}" for level in FRICTION],
        changes=[f"{name} = {value}" for name, value in reproduction.options.truth.items()],
        better=int((own["reduction"] > own["paper_reduction"]).sum()),
        found=found,
    )


def _loop_learning(reproduction: Reproduction) -> Section:
    """Return the learning of the loop, Fig. 5, and what was learned."""
    models = reproduction.loops.study.models
    found, fed = "what was identified", ""
    if models[0].fitted:
        titles = [friction_law(model.law).title for model in models]
        found = f"{' or '.join(titles)}, fitted to the drive’s errors"
        fed = f" The feedforward has the {titles[0]} friction, too."
    figures = {"fig5_fitness": partial(curves.draw_fitness, reproduction.loops)}
    values = {"learning": loop_learning, "search": search, "seconds": training_motion().duration}
    values |= {"found": found, "fed": fed, "kept": kept, "mismatch": models[0].mismatch}
    return section(
        "Learning the loop", "loop_learning", reproduction, figures, PROBES=PROBES, **values
    )


def validation_section(validation: Validation, table4: pd.DataFrame) -> Section:
    """Return the section on validation; Table 4 may have columns of the velocity filter."""
    draw = {"fig6_tracking": partial(curves.draw_tracking, validation)}
    values = {"table4": tables.table4(table4), "filtered": FILTERED in table4, "CUTOFF": CUTOFF}
    return section("Validation", "validation", None, draw, **values)


def _motions(reproduction: Reproduction, frame: pd.DataFrame) -> Section:
    """Return the section on the other motions."""
    slow = frame[frame["motion"] != TRAPEZOID.name]
    left = slow[LEARNED] / slow[UNCOMPENSATED]
    worse = [
        f"{tables.error_name(row)}, {row['velocity']} ({percent(share, 0)})"
        for row, share in zip(slow.to_dict("records"), left, strict=True)
        if share > 1.0
    ]
    return section(
        "Slow reversals, creep and micrometre moves",
        "motions",
        reproduction,
        {"motions": partial(curves.draw_motions, reproduction)},
        slow={motion: tables.motions(own) for motion, own in slow.groupby("motion", sort=False)},
        learned=STEPS[LEARNED],
        worse=worse,
        half=int((left > 0.5).sum()),
        total=len(slow),
        SLOW_MOTIONS=SLOW_MOTIONS,
    )


def study_section(study: PublishedStudy) -> Section:
    """Return the section on the learning as published, beside least squares."""
    return section(
        "The learning as published, and least squares",
        "as_published",
        None,
        {FIG5: partial(curves.draw_band, study)},
        study=study,
        panel=tables.panel(study),
        runs=study.seeds[SQUARES][0].runs,
        samples=round(motions.TRAINING.duration / LOOP.T_s) + 1,
        SPREAD={name: SPREAD[name] for name in LUGRE},
    )


def write_report(reproduction: Reproduction, folder: Path) -> list[Path]:
    """Write the figures as PNG and SVG, and report.html; see ``write_page``."""
    return write_page(folder, TITLE, sections(reproduction))
