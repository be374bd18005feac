"""A system as a package and back."""

from __future__ import annotations

import numpy as np
import pytest
from fmpy.ssp.ssd import read_ssd, read_ssv

from stickslip import cosim

EXPERIMENT = cosim.DefaultExperiment(start=0.0, stop=2.0, step=0.25)


@pytest.fixture
def loop(make):
    system = cosim.System("loop")
    system.add("controller", make("gain", y="mN"), {"k": -0.5, "n": 3, "flag": True, "text": "a<b"})
    system.add("drive", make("integrator"), {"k": 1.0})
    system.add("watch", make("gain"))
    system.connect("drive.y", "controller.u")
    system.connect("controller.y", "drive.u")
    system.expose("force", "watch.u")
    return system


@pytest.fixture
def package(loop, tmp_path):
    return cosim.write_ssp(loop, tmp_path / "loop.ssp", EXPERIMENT)


def run(system):
    return system.prepare(step=EXPERIMENT.step, stop=EXPERIMENT.stop).run(inputs={"force": np.sin})


@pytest.mark.parametrize("version", ["1.0", "2.0"])
def test_round_trip(loop, tmp_path, version):
    package = cosim.write_ssp(loop, tmp_path / "a.ssp", EXPERIMENT, version=version)
    system, experiment = cosim.read_ssp(package)
    assert experiment == EXPERIMENT
    assert system.name == loop.name
    assert list(system.components) == list(loop.components)
    assert system.connections == loop.connections
    assert system.inputs == loop.inputs
    assert system.parameters == loop.parameters
    np.testing.assert_array_equal(run(system).values, run(loop).values)


def test_the_same_system_gives_the_same_bytes(loop, package, tmp_path):
    again = cosim.write_ssp(loop, tmp_path / "again.ssp", EXPERIMENT)
    assert again.read_bytes() == package.read_bytes()
    system, experiment = cosim.read_ssp(package)
    assert cosim.write_ssp(system, again, experiment).read_bytes() == package.read_bytes()


def test_fmpy_finds_it_valid_and_reads_the_same(package):
    ssd = read_ssd(str(package))
    assert [c.name for c in ssd.system.elements] == ["controller", "drive", "watch"]
    values = read_ssv(str(package), "resources/0_controller.ssv")
    assert {p.name: p.value for p in values.parameters}["k"] == "-0.5"
