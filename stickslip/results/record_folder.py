"""The folder that ``stickslip reproduce --mode record`` leaves behind."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from stickslip import models
from stickslip.fmi.files import atomic_write
from stickslip.logs import Recording
from stickslip.pipeline.record_mode import RecordReproduction, gains_of
from stickslip.report.learned import FILES as REPORT
from stickslip.report.learned import write_estimation_report
from stickslip.report.markup import (
    Html,
    element,
    paragraph,
)
from stickslip.report.markup import table as markup_table
from stickslip.report.picture import Picture, picture_files
from stickslip.report.reproduction import (
    fig2,
    fig5,
    fig6,
    section_validation,
)
from stickslip.report.shown import figure
from stickslip.results.folder import staged
from stickslip.results.learned import estimation_document
from stickslip.results.reproduction_folder import (
    command_of,
    write_json,
    write_loop,
    write_table,
)

FILES = (
    *("table2.csv", "table4.csv", "attribution.csv", "fitness.csv", "profiles.csv"),
    *("recording.csv", "recording.toml", "learned.json", "compensator.fmu", "loop.ssp"),
    *picture_files(["fig2_loops", "fig5_fitness", "fig6_tracking"]),
    *REPORT,
)
"""What ``write_record_results`` writes."""


def write_record_results(reproduction: RecordReproduction, folder: Path) -> None:
    """Write the tables, the recording, report, learned.json, compensator.fmu and loop.ssp.

    ``recording.csv`` and ``recording.toml`` are what ``stickslip learn`` needs to learn the same.

    Raises
    ------
    OSError
        When a file cannot be written.
    """
    estimation = reproduction.estimation
    with staged(folder, command_of(reproduction.options, mode="record")) as staging:
        write_table(reproduction.table2(), staging / "table2.csv")
        write_table(reproduction.validation.table(), staging / "table4.csv")
        write_table(reproduction.attribution, staging / "attribution.csv")
        write_table(estimation.algorithm.convergence(), staging / "fitness.csv")
        write_table(estimation.profiles, staging / "profiles.csv")
        _write_recording(estimation.recording, staging / "recording.csv")
        atomic_write(staging / "recording.toml", _description(reproduction))
        seed = reproduction.options.seed
        document = estimation_document(estimation, reproduction.loop, seed)
        write_json(document, staging / "learned.json")
        models.build_fmu("compensator", staging, start=reproduction.compensator)
        write_loop(reproduction.system, reproduction.loop, staging / "loop.ssp")
        drawn = pictures(reproduction)
        for name, picture in drawn.items():
            atomic_write(staging / f"{name}.png", picture.png)
            atomic_write(staging / f"{name}.svg", picture.svg)
        further = sections(reproduction, drawn)
        write_estimation_report(estimation, reproduction.findings, staging, further)


def pictures(reproduction: RecordReproduction) -> dict[str, Picture]:
    """Draw the figures of the paper for what one recording gave."""
    feed = reproduction.options.feed
    cost = r"$\sum (F - F_{implied})^2$ [N$^2$]"
    return {
        "fig2_loops": Picture.of(fig2.draw_loops, reproduction.plain, reproduction.truth, feed),
        "fig5_fitness": Picture.of(fig5.draw_course, reproduction.estimation.algorithm, cost),
        "fig6_tracking": Picture.of(fig6.draw_tracking, reproduction.validation),
    }


def sections(reproduction: RecordReproduction, drawn: Mapping[str, Picture]) -> tuple[Html, ...]:
    """Return what the page says of the loop that was built on what was learned."""
    return (
        section_validation.describe(reproduction.validation, drawn["fig6_tracking"]),
        _attribution(reproduction),
        _loops(reproduction, drawn),
    )


def _attribution(reproduction: RecordReproduction) -> Html:
    table = reproduction.attribution
    metrics = [name for name in table.columns if name.endswith(("E_max", "E_rms"))]
    rows = [
        (
            *("on" if row[part] else "off" for part in ("compensator", "filter", "inertia")),
            row["velocity"],
            *(f"{row[metric]:.3f}" for metric in metrics),
        )
        for row in table.to_dict("records")
    ]
    head = ("Compensator", "Velocity filter", "Feedforward of inertia", "Velocity", *metrics)
    return element(
        "section",
        element("h2", "What each part adds"),
        paragraph(
            "Table 4 compares, on the simulated drive, the paper’s loop without compensation with "
            "the loop that has all three: the learned compensator, a Kalman filter of encoder and "
            "motor force, and feedforward of inertia, which need the learned mass. A velocity "
            "filter that counts on a compensator follows worse without, so the plain loop is the "
            "fair comparison; here are all eight."
        ),
        markup_table(
            head,
            rows,
            "Tracking errors of the simulated drive in mm/s, by what is on",
            (0, 1, 2, 3),
        ),
    )


def _loops(reproduction: RecordReproduction, drawn: Mapping[str, Picture]) -> Html:
    return element(
        "section",
        element("h2", "The loops and the search"),
        paragraph(
            "The simulated drive was recorded once, for 20 s, in a soft loop without compensation "
            "that was designed on its nominal mass. The loop of the paper was then designed on the "
            "mass and viscous friction that the recording gave."
        ),
        figure(
            drawn["fig2_loops"],
            "Block diagrams of the compensated and the nominal loop, and its step response",
            "Fig. 2. The loops; the velocity filter, which takes the place of the velocity "
            "estimate, is not drawn.",
        ),
        figure(
            drawn["fig5_fitness"],
            "Cost over the generations of the search",
            f"Fig. 5. The global search: {reproduction.estimation.algorithm.stopped}. The fit that "
            "follows it has no generations.",
        ),
    )


def _write_recording(recording: Recording, path: Path) -> None:
    table = {
        "time [s]": recording.t,
        "position [m]": recording.position,
        "force [N]": recording.force,
        "velocity_command [m/s]": recording.velocity_command,
    }
    write_table(pd.DataFrame(table), path)


def _description(reproduction: RecordReproduction) -> str:
    """Return what ``stickslip learn --config`` takes."""
    gains = gains_of(reproduction.recording_loop)
    lines = [
        "# Describes recording.csv for stickslip learn.",
        'motion = "linear"',
        f"encoder_step = {reproduction.estimation.recording.encoder_step!r}",
        "",
        "[columns]",
        'time = { name = "time", unit = "s" }',
        'position = { name = "position", unit = "m" }',
        'force = { name = "force", unit = "N" }',
        'velocity_command = { name = "velocity_command", unit = "m/s" }',
        "",
        "[controller]",
        'kind = "PI"',
        *(f"{name} = {value!r}" for name, value in gains.items()),
    ]
    return "\n".join(lines) + "\n"
