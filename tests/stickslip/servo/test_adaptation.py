"""A feedforward that follows the friction of its drive as it drifts."""

import numpy as np
import pytest

from stickslip import cosim, models
from stickslip.servo.systems import Compensator, build_loop
from tests.kept import further

SECONDS, DRIFT_TIME = 24.0, 6.0
SINE = cosim.SineSweep(frequency=(0.5, 0.5), amplitude=(0.02, 0.02), duration=SECONDS)
FIXED = [Compensator("feedforward", "compensator")]
ADAPTED = [*FIXED, Compensator("scale", "adaptive_scale", {"rate": 0.6})]


def track(fmus, loop, chain, **drive):
    """Return the tracking error of the last quarter [m/s], and the result."""
    system = build_loop(fmus, loop, chain)
    record = ["drive.v", "nominal.v_r", *["scale.s"] * (len(chain) > 1)]
    with system.prepare(step=5e-4, stop=SECONDS, record=record) as simulation:
        parameters = {f"drive.{name}": value for name, value in drive.items()}
        result = simulation.run(parameters, inputs={"v_cmd": SINE})
    error = (result["drive.v"] - result["nominal.v_r"])[-len(result.time) // 4 :]
    return float(np.sqrt(np.mean(error**2))), result


@pytest.mark.parametrize(
    ("law", "drift"),
    [
        *(("lugre", 0.3), ("gms", -0.3)),
        *further(("lugre", -0.3), ("gms", 0.3)),
        *further(("coulomb_stribeck", 0.3), ("coulomb_stribeck", -0.3)),
    ],
)
def test_the_adapted_feedforward_holds_its_error_on_a_drifting_drive(
    fmus, loop, tmp_path, law, drift
):
    """Friction changes by 30 %: the fixed one loses its error, the adapted one does not."""
    if law != "lugre":
        for name in ("drive", "compensator"):
            models.build_fmu(name, tmp_path, law=law)
        for name in ("nominal_loop", "velocity_controller", "adaptive_scale"):
            (tmp_path / f"{name}.fmu").symlink_to(fmus / f"{name}.fmu")
        fmus = tmp_path
    drifting = {"drift": drift, "drift_time": DRIFT_TIME}
    cold, _ = track(fmus, loop, FIXED)
    fixed, _ = track(fmus, loop, FIXED, **drifting)
    adapted, result = track(fmus, loop, ADAPTED, **drifting)
    assert fixed > 1.7 * cold
    assert adapted < cold + 0.15 * (fixed - cold)
    warm = 1.0 - drift * (1.0 - np.exp(-SECONDS / DRIFT_TIME))
    assert result["scale.s"][-1] == pytest.approx(warm, abs=0.03)
