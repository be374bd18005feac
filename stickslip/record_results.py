"""The folder that ``stickslip reproduce --mode record`` leaves behind."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

import models
from stickslip.learned import estimation_document
from stickslip.record_mode import RecordReproduction, gains_of
from stickslip.recording import Recording
from stickslip.report import fig2, fig5, fig6
from stickslip.report.picture import Picture
from stickslip.results import manifest, staged, write_json, write_loop, write_table
from toolchain import write_whole


def write_record_results(reproduction: RecordReproduction, folder: Path) -> None:
    """Write the tables, the recording, report, learned.json, compensator.fmu and loop.ssp.

    ``recording.csv`` and ``recording.toml`` are what ``stickslip learn`` needs to learn the same.

    Raises
    ------
    OSError
        When a file cannot be written.
    """
    estimation = reproduction.estimation
    with staged(folder) as desk:
        write_table(reproduction.table2(), desk / "table2.csv")
        write_table(reproduction.validation.table(), desk / "table4.csv")
        write_table(reproduction.attribution, desk / "attribution.csv")
        write_table(estimation.algorithm.convergence(), desk / "fitness.csv")
        write_table(estimation.profiles, desk / "profiles.csv")
        _write_recording(estimation.recording, desk / "recording.csv")
        write_whole(desk / "recording.toml", _description(reproduction))
        seed = reproduction.options.seed
        document = estimation_document(estimation, reproduction.loop, seed)
        write_json(document, desk / "learned.json")
        models.build_fmu("compensator", desk, start=reproduction.compensator)
        write_loop(reproduction.system, reproduction.loop, desk / "loop.ssp")
        for name, picture in pictures(reproduction).items():
            write_whole(desk / f"{name}.png", picture.png)
            write_whole(desk / f"{name}.svg", picture.svg)
        content = manifest(reproduction.options, desk, mode="record")
        write_json(content, desk / "manifest.json")


def pictures(reproduction: RecordReproduction) -> dict[str, Picture]:
    """Draw the figures of the paper for what one recording gave."""
    feed = reproduction.options.feed
    cost = r"$\sum (F - F_{implied})^2$ [N$^2$]"
    return {
        "fig2_loops": Picture.of(fig2.draw_loops, reproduction.plain, reproduction.truth, feed),
        "fig5_fitness": Picture.of(fig5.draw_course, reproduction.estimation.algorithm, cost),
        "fig6_tracking": Picture.of(fig6.draw_tracking, reproduction.validation),
    }


def _write_recording(recording: Recording, path: Path) -> None:
    table = {
        "time_s": recording.t,
        "position_m": recording.position,
        "force_N": recording.force,
        "velocity_command_m/s": recording.velocity_command,
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
        'time = { name = "time_s", unit = "s" }',
        'position = { name = "position_m", unit = "m" }',
        'force = { name = "force_N", unit = "N" }',
        'velocity_command = { name = "velocity_command_m/s", unit = "m/s" }',
        "",
        "[controller]",
        'kind = "PI"',
        *(f"{name} = {value!r}" for name, value in gains.items()),
    ]
    return "\n".join(lines) + "\n"
