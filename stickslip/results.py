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
from stickslip.errors import UsageError
from stickslip.learned import learned_document
from stickslip.report import write_report
from stickslip.reproduction import Reproduction
from stickslip.setup import VALIDATION
from toolchain import write_whole


def claim_folder(folder: Path) -> None:
    """Make the folder and try to write there, before the work begins.

    Raises
    ------
    UsageError
        When that is not possible.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise UsageError(
            f"{folder}: cannot write there ({error.strerror}); choose another folder with --out"
        ) from None


def write_results(reproduction: Reproduction, folder: Path) -> None:
    """Write tables, report, learned.json, compensator.fmu, loop.ssp and manifest.json.

    All of it is written beside first and then moved, so an earlier result stays whole until a new
    one is complete.

    Raises
    ------
    OSError
        When a file cannot be written.
    """
    with tempfile.TemporaryDirectory(dir=folder, prefix=".writing-") as staging:
        desk = Path(staging)
        _write_table(reproduction.table2(), desk / "table2.csv")
        _write_table(reproduction.validation.table(), desk / "table4.csv")
        _write_table(reproduction.algorithm.convergence(), desk / "fitness.csv")
        _write_json(learned_document(reproduction), desk / "learned.json")
        models.build_fmu("compensator", desk, start=reproduction.learned.values)
        _write_loop(reproduction, desk / "loop.ssp")
        write_report(reproduction, desk)
        _write_json(_manifest(reproduction, desk), desk / "manifest.json")
        for path in desk.iterdir():
            path.replace(folder / path.name)


def _manifest(reproduction: Reproduction, folder: Path) -> dict[str, object]:
    """Return what was run and the hashes of the files in a folder."""
    options = reproduction.options
    return {
        "command": {
            "set": {f"drive.{name}": value for name, value in options.truth.items()},
            "seed": options.seed,
            "preset": options.preset,
            "feed": options.feed,
        },
        "sha256": {
            path.name: hashlib.sha256(path.read_bytes()).hexdigest()
            for path in sorted(folder.iterdir())
        },
    }


def _write_table(table: pd.DataFrame, path: Path) -> None:
    write_whole(path, table.to_csv(index=False, lineterminator="\n"))


def _write_json(content: object, path: Path) -> None:
    write_whole(path, json.dumps(content, indent=2) + "\n")


def _write_loop(reproduction: Reproduction, path: Path) -> None:
    """Write the loop of Fig. 2a with the trapezoid as the input that it runs with."""
    run = reproduction.validation.compensated
    step = reproduction.identification.loop.T_s
    experiment = cosim.DefaultExperiment(start=0.0, stop=float(run.t[-1]), step=step)
    cosim.write_ssp(reproduction.system, path, experiment)
    corners = VALIDATION.corners()
    pack_input(path, pd.DataFrame({"time": corners, "v_cmd": VALIDATION.sample(corners)}))
