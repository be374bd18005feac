"""One FMU alone gives FMPy's trajectory bit for bit."""

from __future__ import annotations

import numpy as np
import pytest

from stickslip import cosim
from tests.cosim.single import by_fmpy


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
    how = {"start_time": start, "step_size": step, "start_values": {"k": 1.1}}
    theirs = by_fmpy(path, step, stop, "y", inputs=[simulation.time, ("u", "f8", u)], **how)
    np.testing.assert_array_equal(ours.time, theirs["time"])
    np.testing.assert_array_equal(ours["a.y"], theirs["y"])
