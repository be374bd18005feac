"""Saving the state of the paper's loop and resuming it; tests/cosim covers the rest."""

import numpy as np
import pytest

from stickslip import cosim
from stickslip.servo.systems import paper_loop

STEP, HALF, STOP = 5e-4, 0.1, 0.25


@pytest.fixture
def system(fmus, loop):
    return paper_loop(fmus, loop, {})


@pytest.mark.parametrize("record", [{"every": 7}, {"keep": "last"}])
def test_a_record_continues_where_it_was_saved(system, tmp_path, record):
    sums = {"error": cosim.Deviation("drive.v", "nominal.v_r", begin=HALF / 2)}
    names = ["drive.x_enc", "controller.u"]
    spec = {"step": STEP, "stop": STOP}
    spec["record"] = cosim.Record(names, **record, sum_of_squares=sums)
    inputs = {"v_cmd": lambda t: 0.02 * np.sin(40 * t)}
    with system.prepare(**spec) as simulation:
        whole = simulation.run(inputs=inputs)
        first = simulation.run(inputs=inputs, until=HALF)
        path = simulation.save(tmp_path / "half.state")
    with system.prepare(**spec) as another:
        rest = another.resume(path, inputs)
    assert rest.sum_of_squares == whole.sum_of_squares
    assert 0 < first.sum_of_squares["error"] < whole.sum_of_squares["error"]
    after = whole.time >= HALF
    np.testing.assert_array_equal(rest.time, whole.time[after])
    np.testing.assert_array_equal(rest.values, whole.values[after])


def test_no_state_and_no_step_are_refused(system, tmp_path):
    with system.prepare(step=STEP, stop=STOP) as simulation:
        with pytest.raises(cosim.SimulationError, match="no state to save"):
            simulation.save(tmp_path / "a.state")
        simulation.run(until=HALF)
        path = simulation.save(tmp_path / "a.state")
    with (
        system.prepare(step=STEP, stop=HALF) as shorter,
        pytest.raises(cosim.ExperimentError, match="no step left"),
    ):
        shorter.resume(path)
