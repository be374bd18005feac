"""Table 4 with the velocity filter: the floor that the encoder set to the paper is gone."""

import numpy as np
import pytest

from stickslip import cosim
from stickslip.evaluation.motions import VALIDATION
from stickslip.evaluation.validation import validate
from stickslip.servo.axis import LOOP, Datasheet
from stickslip.servo.systems import paper_loop
from stickslip.servo.tuned_pi import with_inertia, with_velocity_filter
from stickslip.servo.velocity_loop import VelocityLoop, design_velocity_loop

TABLE_2 = {"F_s": 8.999, "F_c": 5.999, "v_s": 5.5697e-4, "sigma_0": 3.9162e5, "sigma_1": 4.4248e3}
EXTRAS = {"asymmetric": 1, "position_dependent": 1, "ripple": 1, "noise": 1}


def loops(compensator: dict[str, float], m: float = 5.557) -> tuple[VelocityLoop, VelocityLoop]:
    """Return the loop of the paper, and the one with filter and feedforward of inertia."""
    plain = design_velocity_loop(Datasheet().axis(m, 6.6135), LOOP)
    filtered = with_velocity_filter(plain, Datasheet(), compensator["F_c"])
    return plain, with_inertia(filtered)


def reductions(make_rig, truth, m=5.557):
    """Return the table, the compensator that of the drive, and the loop without filter plain."""
    compensator = {name: truth.get(name, value) for name, value in TABLE_2.items()}
    plain, filtered = loops(compensator, m)
    rig = make_rig(**truth)
    return validate(rig, filtered, compensator, VALIDATION, plain=plain).table()


@pytest.mark.slow
@pytest.mark.parametrize(
    "truth",
    [
        {"m": 3.0, "F_c": 12.0, "F_s": 20.0},
        {"m": 12.0, "F_c": 3.0, "F_s": 4.0, "sigma_0": 1e6},
        {"F_c": 2.0, "F_s": 3.0, "sigma_0": 1e5},
    ],
    ids=str,
)
def test_other_drives(make_rig, truth):
    table = reductions(make_rig, truth, truth.get("m", 5.557))
    assert (table[table.velocity == "true"].reduction > 0.90).all()


def test_a_drive_with_what_the_compensator_does_not_know(make_rig):
    table = reductions(make_rig, EXTRAS)
    assert (table[table.velocity == "true"].reduction > 0.80).all()


def test_the_compensated_loop_reduces_to_the_nominal_one(make_rig):
    """Exact parameters, nothing quantised: Fig. 2a is Fig. 2b, with the filter in both."""
    rig = make_rig(encoder=0, dac=0)
    _, loop = loops(TABLE_2)
    v_cmd = VALIDATION.sample(rig.samples(2.0))
    with paper_loop(rig.fmus, loop, TABLE_2).prepare(
        step=LOOP.T_s, stop=2.0, record=("drive.v", "nominal.v_r")
    ) as simulation:
        result = simulation.run(inputs=loop.commands(v_cmd))
    error = result["drive.v"] - result["nominal.v_r"]
    assert np.abs(error).max() < 1e-4 * 0.040


def test_an_ssp_of_the_loop_brings_the_filter_along(make_rig, tmp_path):
    rig = make_rig()
    _, loop = loops(TABLE_2)
    system = paper_loop(rig.fmus, loop, TABLE_2)
    path = cosim.write_ssp(system, tmp_path / "loop.ssp")
    commands = loop.commands(VALIDATION.sample(rig.samples(0.5)))
    runs = []
    for one in (system, cosim.read_ssp(path)[0]):
        with one.prepare(step=LOOP.T_s, stop=0.5, record=("drive.v", "filter.v_hat")) as prepared:
            runs.append(prepared.run(inputs=commands).values)
    assert runs[0].tobytes() == runs[1].tobytes()
