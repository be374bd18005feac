"""An FMU that writes into its unpacked files spoils no later run."""

import sys

import pytest

from stickslip import cosim
from tests.corpus.hostile import fmus
from tests.cosim.single import one

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="hostile.c is for Linux"),
]


@pytest.fixture
def writer(tmp_path):
    return fmus.write(tmp_path / "writer.fmu", "DoStep rewrite")


def behaviour(fmu):
    return (fmu.folder / "resources" / "behaviour.txt").read_text()


def test_every_preparation_finds_what_was_packed(writer):
    """With one Fmu object, in children: a library that is loaded here stays loaded."""
    fmu = cosim.Fmu(writer)
    limits = cosim.Isolation(allow=(f"files={fmu.folder}",))
    for _ in range(3):
        with one(fmu).prepare(step=0.01, stop=0.1, isolation=limits) as simulation:
            assert behaviour(fmu) == "DoStep rewrite"
            simulation.run()
        assert behaviour(fmu) == "DoStep abort  "
    assert behaviour(cosim.Fmu(writer)) == "DoStep rewrite"
