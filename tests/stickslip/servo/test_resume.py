"""Saving the state of the paper's loop and resuming it; tests/cosim covers the rest."""

import numpy as np
import pytest

from stickslip import cosim, models
from stickslip.catalog.parameters import LUGRE, PAPER
from stickslip.servo.axis import Axis
from stickslip.servo.systems import paper_loop
from stickslip.servo.velocity_loop import LoopSpecification, design_velocity_loop

STEP, HALF, STOP = 5e-4, 0.1, 0.25


@pytest.fixture(scope="module", params=[2, 3])
def system(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("fmus")
    for name in models.model_names():
        models.build_fmu(name, folder, fmi=request.param)
    loop = design_velocity_loop(Axis(PAPER["m"], PAPER["b"]), LoopSpecification(60.0, 60.0))
    return paper_loop(folder, loop, {name: PAPER[name] for name in LUGRE})


def command(t):
    return 0.02 * np.sin(40 * t)


@pytest.mark.parametrize("record", [{"every": 7}, {"keep": "last"}])
def test_a_record_continues_where_it_was_saved(system, tmp_path, record):
    sums = {"error": cosim.Deviation("drive.v", "nominal.v_r", begin=HALF / 2)}
    names = ["drive.x_enc", "controller.u"]
    spec = {"step": STEP, "stop": STOP}
    spec["record"] = cosim.Record(names, **record, sum_of_squares=sums)
    inputs = {"v_cmd": command}
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
