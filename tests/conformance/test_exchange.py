"""Other tools and an independent calculation get the same results."""

import math

import libcosimpy.CosimExecution
import libcosimpy.CosimManipulator
import libcosimpy.CosimObserver
import libcosimpy.CosimSlave
import numpy as np

from tests.conformance.test_ecos import STEP, STEPS, in_kernel
from tests.cosim.single import exposed


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
    outputs, table = fmu.names("output"), {"time": time, **inputs}
    theirs = fmu.simulate(stop, step, start_values=settings, input=table, output=outputs)
    np.testing.assert_array_equal(ours.time, theirs["time"])
    for name in outputs:
        assert len(np.unique(theirs[name])) > 10
        np.testing.assert_array_equal(ours[f"fmu.{name}"], theirs[name], err_msg=name)


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
