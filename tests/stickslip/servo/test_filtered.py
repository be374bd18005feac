"""Table 4 with the velocity filter: the floor that the encoder set to the paper is gone."""

import pytest

from stickslip.evaluation.motions import VALIDATION
from stickslip.evaluation.validation import validate
from stickslip.servo.axis import LOOP, Datasheet
from stickslip.servo.tuned_pi import with_inertia, with_velocity_filter
from stickslip.servo.velocity_loop import design_velocity_loop

TABLE_2 = {"F_s": 8.999, "F_c": 5.999, "v_s": 5.5697e-4, "sigma_0": 3.9162e5, "sigma_1": 4.4248e3}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("truth", "reduction"),
    [  # the last has what the compensator does not know
        ({"m": 3.0, "F_c": 12.0, "F_s": 20.0}, 0.90),
        ({"m": 12.0, "F_c": 3.0, "F_s": 4.0, "sigma_0": 1e6}, 0.90),
        ({"F_c": 2.0, "F_s": 3.0, "sigma_0": 1e5}, 0.90),
        ({"asymmetric": 1, "position_dependent": 1, "ripple": 1, "noise": 1}, 0.80),
    ],
    ids=str,
)
def test_it_reduces_the_error_of_other_drives(make_rig, truth, reduction):
    compensator = {name: truth.get(name, value) for name, value in TABLE_2.items()}
    plain = design_velocity_loop(Datasheet().axis(truth.get("m", 5.557), 6.6135), LOOP)
    loop = with_inertia(with_velocity_filter(plain, Datasheet(), compensator["F_c"]))
    found = validate(make_rig(**truth), loop, compensator, VALIDATION, plain=plain).table()
    assert (found[found.velocity == "true"].reduction > reduction).all()
