"""The tolerance of solvers: of Model Exchange here, of Co-Simulation in the FMU."""

from __future__ import annotations

import fmpy
import numpy as np
import pytest

from stickslip import cosim
from tests.cosim.single import one

PROPOSED = 'tolerance="1e-3"'


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(("experiment", "told"), [("", 0.0), (PROPOSED, 1e-3)])
@pytest.mark.parametrize("recorded", ["a.told", "a.*"])  # as the loop takes it, on the general path
def test_co_simulation_is_told_what_it_proposed_unless_another_is_given(
    export, version, experiment, told, recorded
):
    path = export("feedthrough", version, "CS", experiment=experiment)
    system = one(path)
    times = {"step": 0.1, "stop": 0.1, "record": [recorded]}
    assert system.prepare(**times).run()["a.told"][-1] == told
    assert system.prepare(**times, tolerance=1e-4).run()["a.told"][-1] == 1e-4
    assert fmpy.simulate_fmu(str(path), stop_time=0.1, output=["told"])["told"][-1] == told


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("experiment", ["", PROPOSED, 'tolerance="-1"'])
def test_model_exchange_takes_the_tolerance_that_fmpy_takes(export, version, experiment):
    path = export("oscillator", version, "ME", experiment=experiment)
    system = one(path)
    ours = system.prepare(step=0.1, stop=5.0).run()
    usual = {"relative_tolerance": 1e-5} if "-1" in experiment else {}
    theirs = fmpy.simulate_fmu(
        str(path), stop_time=5.0, output_interval=0.1, output=["position"], **usual
    )
    np.testing.assert_array_equal(ours["a.position"], theirs["position"])


def test_a_tenth_of_the_tolerance_is_less_error(export):
    system = one(export("oscillator", 3, "ME"))
    errors = []
    for tolerance in (1e-4, 1e-6, 1e-8):
        result = system.prepare(step=0.1, stop=5.0, tolerance=tolerance).run()
        errors.append(abs(result["a.position"] - np.cos(2 * result.time)).max())
    assert errors[0] > 10 * errors[1] > 100 * errors[2]


@pytest.mark.parametrize("tolerance", [0.0, -1e-6, 1.0, float("nan")])
def test_what_is_no_tolerance_is_refused(export, tolerance):
    system = one(export("oscillator", 3))
    with pytest.raises(cosim.ExperimentError, match="between 0 and 1"):
        system.prepare(step=0.1, stop=1.0, tolerance=tolerance)
