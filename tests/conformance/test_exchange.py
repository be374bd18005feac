"""FMPy, libcosim and ecos get the results of our kernel."""

import importlib.util
import json
import math
import os
import subprocess
import sys
from pathlib import Path

import libcosimpy.CosimExecution
import libcosimpy.CosimManipulator
import libcosimpy.CosimObserver
import libcosimpy.CosimSlave
import numpy as np
import pytest

from stickslip import cosim
from tests.cosim.single import by_fmpy, exposed

STEP, STEPS = 5e-4, 200


def test_fmpy_and_our_kernel_give_the_same_bits(fmu):
    step = {2: STEP, 3: 3e-4}[fmu.version]
    stop = 600 * step
    time = np.arange(601) * step
    settings = {
        name: bool(value) if fmu.variables[name].type == "Boolean" else int(value)
        for name, value in fmu.settings().items()
    }
    sizes = enumerate(fmu.sizes().items())
    inputs = {name: size * np.sin(9.0 * (k + 1) * time + k) for k, (name, size) in sizes}
    ours = exposed(fmu.path, settings, "fmu").prepare(step=step, stop=stop).run(inputs=inputs)
    outputs, signals = fmu.names("output"), ((name, "f8", x) for name, x in inputs.items())
    how = {"inputs": [time, *signals], "start_values": settings, "step_size": step}
    theirs = by_fmpy(fmu.path, step, stop, *outputs, **how)
    np.testing.assert_array_equal(ours.time, theirs["time"])
    for name in outputs:
        assert len(np.unique(theirs[name])) > 10
        np.testing.assert_array_equal(ours[f"fmu.{name}"], theirs[name], err_msg=name)


def in_kernel(path, inputs, outputs):
    """Hold the inputs from the start, and the step as it was asked for: so do other masters."""
    times = {"step": STEP, "stop": STEPS * STEP, "constant_step": True}
    result = exposed(path, name="fmu").prepare(**times).run(inputs=inputs)
    return [result[f"fmu.{name}"][-1] for name in outputs]


def test_libcosim_runs_the_fmi_2_one(name, build):
    """Its clock counts nanoseconds and 0.5 ms is a whole number of them, so little is left."""
    fmu = build(name, 2)
    values = {name: 0.7 * size for name, size in fmu.sizes().items()}
    execution = libcosimpy.CosimExecution.CosimExecution.from_step_size(int(STEP * 1e9))
    local = libcosimpy.CosimSlave.CosimLocalSlave(fmu_path=str(fmu.path), instance_name="fmu")
    slave = execution.add_local_slave(local_slave=local)
    observer = libcosimpy.CosimObserver.CosimObserver.create_last_value()
    assert execution.add_observer(observer=observer)
    for n, value in values.items():
        reference = fmu.variables[n].valueReference
        assert execution.real_initial_value(slave, reference, value)
    assert execution.step(step_count=STEPS)
    outputs = fmu.names("output")
    references = [fmu.variables[n].valueReference for n in outputs]
    theirs = observer.last_real_values(slave_index=slave, variable_references=references)
    assert any(theirs)
    for n, value, expected in zip(
        outputs, theirs, in_kernel(fmu.path, values, outputs), strict=True
    ):
        assert math.isclose(value, expected, rel_tol=1e-9), f"{n}: {value} against {expected}"


ecos = pytest.mark.skipif(
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


@ecos
def test_ecos_runs_a_loop_as_one_fmu_to_the_last_bits(build, tmp_path):
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


@ecos
def test_ecos_applies_the_parameters_of_a_package(build, tmp_path):
    """Of every component: the parameter sets of a package have one name."""
    system = cosim.System("loop")
    system.add("a", build("stage", 2).path, {"m": 2.5})
    system.add("b", build("stage", 2).path, {"m": 3.5})
    path = cosim.write_ssp(system, tmp_path / "loop.ssp")
    assert in_ecos(path, {}, ["a::m", "b::m"]) == [2.5, 3.5]
