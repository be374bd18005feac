"""Descriptions as large as tools write them."""

from __future__ import annotations

import gc

import pytest

from benchmarks.coupling import ring
from stickslip import cosim

N = 20_000


@pytest.mark.slow
@pytest.mark.parametrize("version", [2, 3])
def test_a_large_description_is_read_whole(tmp_path, version):
    fmu = cosim.Fmu(ring.build(tmp_path, "mass", version, extra=N))
    assert gc.isenabled()
    assert len(fmu.variables) == N + len(ring.MODELS["mass"]) + (version == 3)  # the time
    assert fmu.variables[f"copy[{N - 1}]"].causality == "output"
    assert not fmu.feedthrough[f"copy[{N - 1}]"]


def test_a_few_of_very_many_variables_are_recorded(tmp_path):
    system = cosim.System()
    system.add("mass", ring.build(tmp_path, "mass", 2, extra=N), {"u": 1.0})
    result = system.prepare(step=0.1, stop=1.0, record=["mass.copy[7]", "mass.v"]).run()
    assert result["mass.copy[7]"][-1] == result["mass.v"][-1] > 0
