"""The folder that a reproduction leaves behind."""

from __future__ import annotations

import hashlib
import json
import tempfile
from pathlib import Path

import pandas as pd

import cosim
import models
from stickslip.default_input import pack_input
from stickslip.learned import learned_document
from stickslip.report import write_report
from stickslip.reproduction import Reproduction
from stickslip.setup import VALIDATION
from toolchain import write_whole


def claim_folder(folder: Path) -> None:
    """Make the folder and try to write there, before the work begins.

    Raises
    ------
    OSError
        When that is not possible.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=folder):
        pass


def write_results(reproduction: Reproduction, folder: Path) -> None:
    """Write tables, report, learned.json, compensator.fmu, loop.ssp and, last, manifest.json.

    Raises
    ------
    OSError
        When a file cannot be written; each is there whole or as it was before.
    """
    written = [
        _write_table(reproduction.table2(), folder / "table2.csv"),
        _write_table(reproduction.validation.table(), folder / "table4.csv"),
        _write_table(reproduction.algorithm.convergence(), folder / "fitness.csv"),
        _write_json(learned_document(reproduction), folder / "learned.json"),
        models.build_fmu("compensator", folder, start=reproduction.learned.values),
        _write_loop(reproduction, folder / "loop.ssp"),
        *write_report(reproduction, folder),
    ]
    options = reproduction.options
    manifest = {
        "command": {
            "set": {f"drive.{name}": value for name, value in options.truth.items()},
            "seed": options.seed,
            "preset": options.preset,
            "feed": options.feed,
        },
        "sha256": {
            str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in sorted(written)
        },
    }
    _write_json(manifest, folder / "manifest.json")


def _write_table(table: pd.DataFrame, path: Path) -> Path:
    return write_whole(path, table.to_csv(index=False, lineterminator="\n"))


def _write_json(content: object, path: Path) -> Path:
    return write_whole(path, json.dumps(content, indent=2) + "\n")


def _write_loop(reproduction: Reproduction, path: Path) -> Path:
    """Write the loop of Fig. 2a with the trapezoid as the input that it runs with."""
    run = reproduction.validation.compensated
    step = reproduction.identification.loop.T_s
    experiment = cosim.DefaultExperiment(start=0.0, stop=float(run.t[-1]), step=step)
    cosim.write_ssp(reproduction.system, path, experiment)
    corners = VALIDATION.corners()
    return pack_input(path, pd.DataFrame({"time": corners, "v_cmd": VALIDATION.sample(corners)}))
