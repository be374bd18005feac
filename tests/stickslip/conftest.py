"""One reproduction, one short log and what is learned of it, made once for all tests of them."""

import io
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import pytest

from stickslip.catalog.parameters import PAPER
from stickslip.cli import main
from stickslip.identification.stages import Identification, identify
from stickslip.models import build_fmu
from stickslip.output import SILENT, Progress, shown_by
from stickslip.papers.lugre.folder import write_results
from stickslip.papers.lugre.reproduction import Options, Reproduction, reproduce
from stickslip.planning import LINEAR, plan
from stickslip.rigs.contract import COMMISSIONING
from stickslip.rigs.fmu import FmuRig, rig_of
from stickslip.servo.axis import LOOP, Axis, Datasheet
from stickslip.servo.systems import build_fmus
from stickslip.servo.velocity_loop import VelocityLoop, design_velocity_loop
from stickslip.studies.learn import log_learning
from stickslip.studies.learn.learned import LearnedFromRecording
from stickslip.tuning.loop_learning import EVALUATIONS
from tests.kept import kept
from tests.stickslip.brief import blank, briefly


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
    monkeypatch.setattr("stickslip.presentation.page.Picture.of", blank)


def reproduced(fmus: Path, share: int = 4) -> Reproduction:
    with pytest.MonkeyPatch.context() as patch:  # a part of the search learns nearly the same
        patch.setattr("stickslip.tuning.loop_learning.EVALUATIONS", EVALUATIONS // share)
        return reproduce(Options(seeds=1), fmus, SILENT, 2)


@pytest.fixture(scope="session")
def reproduction() -> Reproduction:
    return kept("reproduction", reproduced)


@pytest.fixture(scope="session")
def results(reproduction) -> Path:
    """Return a folder of results."""

    def written(folder: Path) -> Path:
        with pytest.MonkeyPatch.context() as patch:  # test_report.py draws the figures
            patch.setattr("stickslip.presentation.page.Picture.of", blank)
            write_results(reproduction, folder)
        return folder

    return kept("results", written)


@pytest.fixture
def untried(monkeypatch):
    """Leave out the trial of the compensator, most of the time of a whole learning."""
    place = "stickslip.studies.learn.log_learning.with_trial"
    monkeypatch.setattr(place, lambda _, learned, *__: learned)


@pytest.fixture(scope="session")
def fmus(tmp_path_factory) -> Path:
    """Return a folder with the paper's drive and all that its loops are made of."""
    folder = tmp_path_factory.mktemp("fmus")
    build_fmus(folder, {})
    return folder


@pytest.fixture(scope="session")
def loop() -> VelocityLoop:
    """Return the paper's loop, designed for the parameters of its Table 2."""
    return design_velocity_loop(Axis(PAPER["m"], PAPER["b"], 1e-4), LOOP)


@pytest.fixture(scope="session")
def identified(fmus) -> Identification:
    """Return what the paper's experiments find of its drive."""
    return identify(FmuRig(fmus, Datasheet(), LOOP.T_s), LOOP)


@pytest.fixture(scope="session")
def stage(tmp_path_factory) -> Path:
    return build_fmu("stage", tmp_path_factory.mktemp("stage"))


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


@pytest.fixture(scope="module")
def brief() -> Iterator[None]:
    with briefly():
        yield


ASKED = ("--criterion", "inverse", "--seed", "3", "--compensator", "static+ekbf")


@pytest.fixture(scope="session")
def learned_log(log) -> SimpleNamespace:
    """Return what the command learned of the short log, its folder and what was printed."""

    def learned(folder: Path) -> SimpleNamespace:
        steps, found, out = [], [], folder / "out"

        def learn(*arguments, **options) -> LearnedFromRecording:
            found.append(own(*arguments, **options))
            return found[0]

        own = log_learning.learn
        with (
            briefly() as patch,
            redirect_stdout(io.StringIO()) as said,
            redirect_stderr(io.StringIO()) as warned,
            shown_by(lambda done, of: steps.append((done, of))),
        ):
            patch.setattr(log_learning, "learn", learn)
            words = ["learn", "--log", str(log), *ASKED, "--workers", "1", "--out", str(out), "-v"]
            assert main(words) == 0
        printed = {"said": said.getvalue(), "warned": warned.getvalue()}
        return SimpleNamespace(folder=out, learned=found[0], steps=steps, **printed)

    return kept("learned_log", learned)
