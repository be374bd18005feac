"""The folder that a reproduction leaves behind."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from stickslip import cosim, models
from stickslip.default_input import pack_input
from stickslip.evaluation.fmpy_check import SecondOpinion, second_opinion
from stickslip.fmi.files import atomic_write
from stickslip.pipeline.reproduction import Options, Reproduction
from stickslip.report.reproduction import FILES as REPORT
from stickslip.report.reproduction import write_report
from stickslip.results.folder import staged
from stickslip.results.learned import reproduction_document
from stickslip.servo.datasheet import TRAINING, VALIDATION
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.tuning.published.readings import TABLES

PREFIX = "as_published_"
"""Of the tables of the learning as published."""
FILES = (
    *("table2.csv", "table4.csv", "table4_all_extras.csv", "motions.csv", "sensitivity.csv"),
    *("datasheet.csv", "fitness.csv", "learned.json", "compensator.fmu", "loop.ssp"),
    *(f"{PREFIX}{name}.csv" for name in TABLES),
    *REPORT,
)
"""What ``write_results`` writes."""


def write_results(reproduction: Reproduction, folder: Path) -> None:
    """Write tables, report, learned.json, compensator.fmu and loop.ssp.

    An earlier result stays whole until the new one is complete.

    Raises
    ------
    OSError
        When a file cannot be written.
    """
    with staged(folder, command_of(reproduction.options)) as staging:
        write_table(reproduction.table2(), staging / "table2.csv")
        write_table(reproduction.table4(), staging / "table4.csv")
        if reproduction.extras and reproduction.extras.table4 is not None:
            write_table(reproduction.extras.table4, staging / "table4_all_extras.csv")
        if reproduction.published:
            for name, table in reproduction.published.tables().items():
                write_table(table, staging / f"{PREFIX}{name}.csv")
        if reproduction.beforehand is not None:
            write_table(reproduction.beforehand, staging / "datasheet.csv")
        if reproduction.motions:
            write_table(reproduction.motions.evaluation.table(), staging / "motions.csv")
            write_table(reproduction.motions.sensitivity, staging / "sensitivity.csv")
        write_table(reproduction.algorithm.convergence(), staging / "fitness.csv")
        learned, law = reproduction.refinement, reproduction.options.law
        fmu = models.build_fmu("compensator", staging, start=learned.values, law=law)
        reproduction = replace(reproduction, opinion=opinion_of(reproduction, fmu))
        write_json(reproduction_document(reproduction), staging / "learned.json")
        write_loop(reproduction.system, reproduction.identification.loop, staging / "loop.ssp")
        write_report(reproduction, staging)


def opinion_of(reproduction: Reproduction, fmu: Path) -> SecondOpinion:
    """Return what FMPy makes of the compensator over the training and the validation command."""
    loop = reproduction.identification.loop
    t = np.arange(round(TRAINING.duration / loop.T_s) + 1) * loop.T_s
    commands = {
        "training": TRAINING.sample(np.asarray(t)),
        "validation": reproduction.validation.compensated.v_cmd,
    }
    return second_opinion(fmu, reproduction.system, loop, commands)


def command_of(options: Options, **more: object) -> dict[str, object]:
    """Return what the manifest says of a reproduction."""
    return {
        "name": "reproduce",
        "set": {f"drive.{name}": value for name, value in options.truth.items()},
        "seed": options.seed,
        "preset": options.preset,
        "feed": options.feed,
        "coarse": dict(options.coarse),
        **({} if options.law == "lugre" else {"law": options.law}),
        **more,
    }


def write_table(table: pd.DataFrame, path: Path) -> None:
    """Write a table as CSV, whole."""
    atomic_write(path, table.to_csv(index=False, lineterminator="\n"))


def write_json(content: object, path: Path) -> None:
    """Write plain data as JSON, whole."""
    atomic_write(path, json.dumps(content, indent=2) + "\n")


def write_loop(system: cosim.System, loop: VelocityLoop, path: Path) -> None:
    """Write the loop of Fig. 2a with the trapezoid as the input that it runs with."""
    corners = VALIDATION.corners()
    t = np.arange(round((corners[-1] + VALIDATION.begin) / loop.T_s) + 1) * loop.T_s
    stop = float(t[-1])
    experiment = cosim.DefaultExperiment(start=0.0, stop=stop, step=loop.T_s)
    cosim.write_ssp(system, path, experiment)
    table = pd.DataFrame({"time": corners, "v_cmd": VALIDATION.sample(corners)})
    if loop.m_ff:
        table = pd.DataFrame({"time": t, **loop.commands(VALIDATION.sample(np.asarray(t)))})
    pack_input(path, table)
