"""The PI controller that is tuned against friction without a compensator."""

import control
import numpy as np
import pytest

from stickslip.servo.axis import LOOP, Axis
from stickslip.servo.sensitivity import peak_sensitivity
from stickslip.servo.tuned_pi import tuned_pi
from stickslip.servo.velocity_loop import (
    LoopSpecification,
    close_velocity_loop,
    design_velocity_loop,
)

AXES = {
    "the paper's": (Axis(5.557, 6.6, 1e-4), LOOP),
    "light, slow loop": (Axis(0.8, 0.1, 3e-4), LoopSpecification(40.0, 65.0, T_s=1e-3)),
    "heavy": (Axis(40.0, 60.0, 1e-3), LoopSpecification(30.0, 55.0, T_s=5e-4, tau_f=1e-3)),
}


def sensitivity(loop):
    """Return max |1 / (1 + L)| by python-control, on a grid of our own."""
    w = np.linspace(1e-3, 1.0, 20000) * np.pi / loop.T_s
    return np.abs(control.feedback(1, loop.open_loop)(np.exp(1j * w * loop.T_s))).max()


@pytest.mark.slow
@pytest.mark.parametrize(("axis", "specification"), AXES.values(), ids=AXES)
def test_it_rejects_friction_best_at_the_same_peak_sensitivity(axis, specification):
    loop = design_velocity_loop(axis, specification)
    tuned = tuned_pi(loop)
    limit = sensitivity(loop)
    assert peak_sensitivity(loop) == pytest.approx(limit, rel=1e-3)
    assert sensitivity(tuned) == pytest.approx(limit, rel=1e-3)
    assert tuned.K_i > 1.2 * loop.K_i
    gains = (axis, loop.T_s, loop.tau_f)
    for factor in np.linspace(0.5, 1.5, 11):  # no other K_p allows 1 % more K_i
        other = close_velocity_loop(*gains, factor * tuned.K_p, 1.01 * tuned.K_i)
        assert sensitivity(other) > limit
