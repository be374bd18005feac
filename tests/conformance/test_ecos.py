"""ecos runs the FMUs of FMI 2.0 to the last bits of our kernel."""

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from stickslip import cosim
from tests.cosim.single import exposed

STEP, STEPS = 5e-4, 200

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("ecospy") is None, reason="ecospy is not installed here"
)


def in_ecos(path, inputs, outputs):
    libraries = os.pathsep.join([str(Path(sys.prefix, "lib")), *sys.path])
    done = subprocess.run(
        [
            *(sys.executable, str(Path(__file__).with_name("ecos_run.py")), str(path)),
            *(repr(STEP), str(STEPS), json.dumps(inputs), json.dumps(outputs)),
        ],
        env=os.environ | {"LD_LIBRARY_PATH": libraries},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def in_kernel(path, inputs, outputs):
    """Hold the inputs from the start, and the step as it was asked for: so does ecos."""
    times = {"step": STEP, "stop": STEPS * STEP, "constant_step": True}
    result = exposed(path, name="fmu").prepare(**times).run(inputs=inputs)
    return [result[f"fmu.{name}"][-1] for name in outputs]


def test_a_model(name, build):
    fmu = build(name, 2)
    inputs = {name: 0.7 * size for name, size in fmu.sizes().items()}
    outputs = fmu.names("output")
    theirs = in_ecos(fmu.path, inputs, outputs)
    assert any(theirs)
    assert theirs == in_kernel(fmu.path, inputs, outputs)


def test_a_whole_loop_as_one_fmu(build, tmp_path):
    system = cosim.System("loop")
    for component in ("velocity_controller", "stage"):
        system.add(component, build(component, 2).path)
    system.connect("velocity_controller.u", "stage.u")
    system.connect("stage.x", "velocity_controller.x_enc")
    system.expose("v_cmd", "velocity_controller.v_cmd")
    path = cosim.write_fmu(system, tmp_path / "loop.fmu", step=STEP)
    outputs = ["stage.v", "velocity_controller.u"]
    theirs = in_ecos(path, {"v_cmd": 0.005}, outputs)
    assert theirs[0] == pytest.approx(0.005, rel=0.1)
    assert theirs == in_kernel(path, {"v_cmd": 0.005}, outputs)


def test_parameters_of_a_package_are_applied(build, tmp_path):
    """Of every component: the parameter sets of a package have one name."""
    system = cosim.System("loop")
    system.add("a", build("stage", 2).path, {"m": 2.5})
    system.add("b", build("stage", 2).path, {"m": 3.5})
    path = cosim.write_ssp(system, tmp_path / "loop.ssp")
    assert in_ecos(path, {}, ["a::m", "b::m"]) == [2.5, 3.5]
