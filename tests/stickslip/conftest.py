"""One reproduction of the paper, and one short log, made once for all tests that judge them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from stickslip import cosim
from stickslip.evaluation.motions import VALIDATION
from stickslip.evaluation.validation import validate
from stickslip.output import SILENT, Progress
from stickslip.papers.lugre.folder import write_results
from stickslip.papers.lugre.reproduction import Extras, Options, Reproduction, reproduce
from stickslip.papers.lugre.studies import step_by_step, with_motions
from stickslip.planning import LINEAR, plan
from stickslip.presentation.page import Picture
from stickslip.rigs.contract import COMMISSIONING
from stickslip.rigs.fmu import FmuRig, rig_of
from stickslip.servo.axis import LOOP, Datasheet
from stickslip.servo.systems import build_fmus
from stickslip.servo.velocity_loop import design_velocity_loop
from stickslip.work.jobs import Execution


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what needs a whole reproduction as slow."""
    for item in items:
        if {"reproduction", "results"} & {*getattr(item, "fixturenames", ())}:
            item.add_marker(pytest.mark.slow)


@pytest.fixture(scope="session")
def quiet() -> Progress:
    return SILENT


@pytest.fixture
def without_pictures(monkeypatch):
    """Leave the figures of a report blank: drawing takes half of the time of a short learning."""
    monkeypatch.setattr(
        "stickslip.presentation.page.Picture.of", lambda *_: Picture(b"", b"", 89.0)
    )


@pytest.fixture(scope="session")
def reproduction(tmp_path_factory, quiet) -> Reproduction:
    fmus = tmp_path_factory.mktemp("fmus")
    return with_motions(reproduce(Options(loop_seeds=1), fmus, quiet, Execution(2)), fmus)


@pytest.fixture(scope="session")
def results(reproduction, tmp_path_factory) -> Path:
    """Return a folder of results; the drive with all extras, which takes long, is the drive."""
    folder = tmp_path_factory.mktemp("results")
    fmus = reproduction.system.components["drive"].path.parent
    extras = Extras(step_by_step(reproduction, fmus))
    write_results(replace(reproduction, extras=extras), folder)
    return folder


@pytest.fixture
def make_rig(tmp_path):
    """Return a function that builds a rig around a drive with the given truth."""

    def make(**truth: float) -> FmuRig:
        build_fmus(tmp_path, truth)
        return FmuRig(tmp_path, Datasheet(), LOOP.T_s)

    return make


@pytest.fixture(scope="session")
def log(tmp_path_factory):
    """Return a log of 2 s of a drive with m = 8 kg and F_c = 4 N, every other sample."""
    path = tmp_path_factory.mktemp("log") / "log.csv"
    with rig_of({"m": 8.0, "F_c": 4.0}) as rig:
        loop = design_velocity_loop(rig.datasheet.axis(5.5, 0.0), COMMISSIONING)
        v_cmd = plan(replace(LINEAR, duration=2.0))["velocity_command"].to_numpy()
        log = rig.follow(v_cmd, loop)
    table = {"time": log.t, "position": log.x_enc, "force": log.F_m}
    pd.DataFrame(table)[::2].to_csv(path, index=False)
    return path


TRAPEZOIDS = 9


def median_reductions(rig, loop, compensator, velocity):
    """Return Table 4's four reductions, each the median of trapezoids that differ by 1 %.

    How the encoder's steps fall is chance, and moves the maximum of one run by some points.
    """
    tables = []
    for k in range(TRAPEZOIDS):
        command = cosim.Trapezoid(
            height=VALIDATION.height * (1.0 + 0.01 * np.sin(3.0 * k)),
            slope=VALIDATION.slope * (1.0 + 0.01 * np.sin(7.0 * k)),
            plateau=VALIDATION.plateau,
            begin=VALIDATION.begin,
        )
        table = validate(rig, loop, compensator, command).table()
        tables.append(table[table.velocity == velocity].reduction.to_numpy())
    return np.median(tables, axis=0)


@pytest.fixture(scope="session")
def reductions():
    """Return what finds Table 4's reductions without the chance of a single run."""
    return median_reductions
