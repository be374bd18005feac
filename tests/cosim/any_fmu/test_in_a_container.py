"""Integers, Booleans and events in a container: the values of the system, in FMPy."""

from __future__ import annotations

import numpy as np
import pytest

from stickslip import cosim
from tests.cosim.single import by_fmpy, one

STEP, STOP = 0.05, 2.0


@pytest.mark.parametrize(("version", "interface", "fmi"), [(2, "CS", 3), (3, "CS events", 2)])
def test_a_container_gives_the_values_of_the_system(export, tmp_path, version, interface, fmi):
    system = one(export("stair", version, interface), {"period": 0.13}, u="trigger")
    system.add("b", export("feedthrough", version, interface))
    system.connect("a.count", "b.Int32_in")
    system.connect("a.level", "b.Float64_in")
    system.expose("on", "b.Boolean_in")
    with system.prepare(step=STEP, stop=STOP) as simulation:
        time = simulation.time
        u, on = np.floor(time / 0.35) % 2 > 0, time > 1.0
        ours = simulation.run(inputs={"u": u, "on": on})
    path = cosim.write_fmu(system, tmp_path / "a.fmu", step=STEP, fmi=fmi)
    names = ["a.count", "a.level", "b.Int32_out", "b.Boolean_out", "b.Float64_out"]
    theirs = by_fmpy(path, STEP, STOP, *names, inputs=[time, ("u", "?", u), ("on", "?", on)])
    for name in names:
        assert len(np.unique(ours[name])) > 1
        np.testing.assert_array_equal(theirs[name], ours[name])
    assert theirs["b.Boolean_out"].dtype == np.bool_
    assert theirs["b.Int32_out"].dtype == np.int32


def test_what_a_container_does_not_run(export, tmp_path):
    system = one(export("stair", 2, "ME"))
    with pytest.raises(cosim.FmuError, match=r"a \(stair.fmu\) cannot .* it runs by Model Exch"):
        cosim.write_fmu(system, tmp_path / "a.fmu", step=STEP)
    wide = one(export("feedthrough", 3, "CS"), u="Int64_in")
    with pytest.raises(cosim.ConnectionFault, match="input u is a Int64, which a container does"):
        cosim.write_fmu(wide, tmp_path / "a.fmu", step=STEP)
