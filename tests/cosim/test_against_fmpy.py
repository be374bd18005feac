"""One FMU alone gives FMPy's trajectory bit for bit."""

from __future__ import annotations

import fmpy
import numpy as np
import pytest

from stickslip import cosim


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("kind", ["gain", "integrator"])
@pytest.mark.parametrize(("step", "stop", "start"), [(5e-4, 2.0, 0.0), (1e-3, 1.3, 0.3)])
def test_same_bits(make, version, kind, step, stop, start):
    path = make(kind, version)
    system = cosim.System()
    system.add("a", path, {"k": 1.1})
    system.expose("u", "a.u")
    with system.prepare(step=step, stop=stop, start=start) as simulation:
        u = np.sin(7 * simulation.time)
        ours = simulation.run(inputs={"u": u})
    table = np.array(
        list(zip(simulation.time, u, strict=True)), dtype=[("time", "f8"), ("u", "f8")]
    )
    theirs = fmpy.simulate_fmu(
        str(path),
        start_time=start,
        stop_time=stop,
        output_interval=step,
        step_size=step,
        start_values={"k": 1.1},
        input=table,
        output=["y"],
    )
    np.testing.assert_array_equal(ours.time, theirs["time"])
    np.testing.assert_array_equal(ours["a.y"], theirs["y"])


@pytest.mark.parametrize("version", [2, 3])
def test_same_bits_between_the_points_of_a_table(make, version):
    path = make("gain", version)
    nodes = np.sort(np.random.default_rng(0).uniform(-0.1, 1.1, 23))
    values = np.random.default_rng(1).normal(size=23)
    system = cosim.System()
    system.add("a", path)
    system.expose("u", "a.u")
    with system.prepare(step=1e-3, stop=1.0) as simulation:
        ours = simulation.run(inputs={"u": cosim.Table(nodes, values)})
    table = np.array(list(zip(nodes, values, strict=True)), dtype=[("time", "f8"), ("u", "f8")])
    theirs = fmpy.simulate_fmu(
        str(path), stop_time=1.0, output_interval=1e-3, step_size=1e-3, input=table, output=["y"]
    )
    np.testing.assert_array_equal(ours["a.y"], theirs["y"])
