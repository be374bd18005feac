"""The same results, bit for bit, whatever the processor and the system."""

import numpy as np
import pytest

from stickslip import models
from stickslip.fmi.toolchain import host_platform

HOST = host_platform().tuple


@pytest.mark.parametrize("platform", ["aarch64-linux", "x86_64-windows"])
@pytest.mark.parametrize("version", [2, 3], ids=["fmi2", "fmi3"])
@pytest.mark.parametrize("name", models.model_names())
def test_results_are_those_of_this_machine(run, name, version, platform):
    if platform == HOST:
        pytest.skip("this is the platform that the others are compared with")
    here, there = run(name, version, HOST), run(name, version, platform)
    assert len(np.unique(here, axis=0)) > 300
    assert here.tobytes() == there.tobytes()
