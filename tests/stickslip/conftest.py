"""One reproduction of the paper, computed once for all tests that judge it."""

from pathlib import Path

import pytest

from stickslip.loop import build_fmus
from stickslip.reproduction import Options, Reproduction, reproduce
from stickslip.results import write_results
from stickslip.rig import Rig
from stickslip.setup import LOOP, Datasheet


class Quiet:
    """Progress that nobody watches."""

    def stage(self, name):
        pass

    def generation(self, algorithm):
        pass


@pytest.fixture(scope="session")
def quiet() -> Quiet:
    return Quiet()


@pytest.fixture(scope="session")
def reproduction(tmp_path_factory, quiet) -> Reproduction:
    return reproduce(Options(), tmp_path_factory.mktemp("fmus"), quiet)


@pytest.fixture(scope="session")
def results(reproduction, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("results")
    write_results(reproduction, folder)
    return folder


@pytest.fixture
def make_rig(tmp_path):
    """Return a function that builds a rig around a drive with the given truth."""

    def make(**truth: float) -> Rig:
        build_fmus(tmp_path, truth)
        return Rig(tmp_path, Datasheet(), LOOP.T_s)

    return make
