from pathlib import Path

import pytest

from stickslip import models
from stickslip.servo.axis import Axis
from stickslip.servo.velocity_loop import LoopSpecification, VelocityLoop, design_velocity_loop


@pytest.fixture(scope="session")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fmus")
    for name in ("nominal_loop", "velocity_controller", "velocity_filter", "drive"):
        models.build_fmu(name, folder)
    return folder


# With and without lag and filter: five, four and three states.
@pytest.fixture(params=[(1e-4, 5e-4), (0.0, 5e-4), (1e-4, 0.0), (0.0, 0.0)], ids=str)
def loop(request: pytest.FixtureRequest) -> VelocityLoop:
    tau_i, tau_f = request.param
    axis = Axis(m=5.557, b=6.6135, tau_i=tau_i)
    return design_velocity_loop(axis, LoopSpecification(125.0, 50.0, 5e-4, tau_f))
