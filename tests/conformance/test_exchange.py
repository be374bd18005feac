"""Other tools and an independent calculation get the same results."""

import math

import libcosimpy.CosimExecution
import libcosimpy.CosimManipulator
import libcosimpy.CosimObserver
import libcosimpy.CosimSlave
import numpy as np
import pytest

from stickslip import cosim, models
from stickslip.models.export.presentation import reference_file

STEP = 5e-4  # s

# Largest distance to reference.csv, in the column's unit. The stage's step is accurate to a part
# in 1e6 of the motion. The drive's puts two constant forces in place of the lagging one, and
# its encoder may show the neighbouring step. What is calculated in closed form or by
# difference equations differs in the last bits only.
TOLERANCE = {
    "stage": {"x": 1e-9, "v": 5e-8, "F_f": 2e-4},
    "drive": {"x_enc": 4.1e-7, "F_m": 1e-12, "F_f": 2e-3, "x": 1e-9, "v": 3e-7},
    "compensator": {"F_f": 1e-12, "F_mean": 1e-12},
    "velocity_controller": {"u": 1e-11, "v_est": 1e-14},
    "velocity_filter": {"v_hat": 1e-13, "d_hat": 1e-8},
    "nominal_loop": {"v_r": 1e-15},
    "static_feedforward": {"F": 1e-12},
    "dob": {"F": 1e-8, "d_hat": 1e-8},
    "coulomb_observer": {"F": 1e-8, "a_hat": 1e-8},
    "momentum_observer": {"F": 1e-8, "a_hat": 1e-8},
    "adaptive_scale": {"F": 1e-9},
    "lffc": {"F": 1e-9},
    "lugre_network": {"F": 1e-9},
    "rbf": {"F": 1e-9},
    "mlp": {"F": 1e-9},
    "lugre_observer": {"F": 1e-8, "z_hat": 1e-14},
    "command_feedforward": {"F_ff": 1e-12, "v_r": 1e-15},
    "command_static": {"F_ff": 1e-12, "v_r": 1e-15},
}


def _alone(fmu, time):
    """Return a system of this FMU with its inputs exposed, and their values over time."""
    system = cosim.System(fmu.model.name)
    settings = {
        name: bool(value) if fmu.variables[name].type == "Boolean" else int(value)
        for name, value in fmu.settings().items()
    }
    system.add("fmu", fmu.path, settings)
    inputs = {}
    for k, (name, size) in enumerate(fmu.sizes().items()):
        system.expose(name, f"fmu.{name}")
        inputs[name] = size * np.sin(9.0 * (k + 1) * time + k)
    return system, settings, inputs


def test_fmpy_and_our_kernel_give_the_same_bits(fmu):
    step = {2: STEP, 3: 3e-4}[fmu.version]
    stop = 600 * step
    time = np.arange(601) * step
    system, settings, inputs = _alone(fmu, time)
    ours = system.prepare(step=step, stop=stop).run(inputs=inputs)
    outputs, table = fmu.names("output"), {"time": time, **inputs}
    theirs = fmu.simulate(stop, step, start_values=settings, input=table, output=outputs)
    np.testing.assert_array_equal(ours.time, theirs["time"])
    for name in outputs:
        assert len(np.unique(theirs[name])) > 10
        np.testing.assert_array_equal(ours[f"fmu.{name}"], theirs[name], err_msg=name)


def test_libcosim_runs_the_fmi_2_one(name, build):
    """Its clock counts nanoseconds and 0.5 ms is a whole number of them, so little is left."""
    fmu = build(name, 2)
    steps = 100
    system, _, _ = _alone(fmu, np.zeros(1))
    system.parameters.clear()
    values = {name: 0.7 * size for name, size in fmu.sizes().items()}
    ours = system.prepare(step=STEP, stop=steps * STEP).run(inputs=values)

    execution = libcosimpy.CosimExecution.CosimExecution.from_step_size(int(STEP * 1e9))
    local = libcosimpy.CosimSlave.CosimLocalSlave(fmu_path=str(fmu.path), instance_name="fmu")
    slave = execution.add_local_slave(local_slave=local)
    observer = libcosimpy.CosimObserver.CosimObserver.create_last_value()
    assert execution.add_observer(observer=observer)
    for n, value in values.items():
        reference = fmu.variables[n].valueReference
        assert execution.real_initial_value(slave, reference, value)
    assert execution.step(step_count=steps)
    outputs = fmu.names("output")
    references = [fmu.variables[n].valueReference for n in outputs]
    theirs = observer.last_real_values(slave_index=slave, variable_references=references)
    assert any(theirs)
    for n, value in zip(outputs, theirs, strict=True):
        expected = ours[f"fmu.{n}"][-1]
        assert math.isclose(value, expected, rel_tol=1e-9), f"{n}: {value} against {expected}"


def test_the_expected_result_beside_the_model_is_met(fmu):
    path = reference_file(fmu.model)
    if path is None:
        pytest.skip("the reference of a plant is for its default law")
    columns = cosim.Table.all_from_csv(path)
    outputs = fmu.names("output")
    inputs = fmu.names("input")
    assert set(columns) == {*inputs, *outputs}
    time = next(iter(columns.values())).time
    step = time[1]
    system = cosim.System()
    system.add("fmu", fmu.path)
    for name in inputs:
        system.expose(name, f"fmu.{name}")
    with system.prepare(step=step, stop=time[-1]) as simulation:
        result = simulation.run(inputs={name: columns[name].values for name in inputs})
    assert set(TOLERANCE[fmu.model.name]) == set(outputs)
    for name in outputs:
        expected = columns[name].values
        assert np.ptp(expected) > 100 * TOLERANCE[fmu.model.name][name]
        np.testing.assert_allclose(
            result[f"fmu.{name}"],
            expected,
            rtol=0.0,
            atol=TOLERANCE[fmu.model.name][name],
            err_msg=name,
        )


def test_every_model_has_a_stated_tolerance():
    assert set(TOLERANCE) == set(models.model_names())
