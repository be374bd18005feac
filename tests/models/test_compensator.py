"""The compensator: the closed form of the bristle, fed by a velocity."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from stickslip import cosim
from tests.models.contacts import contacts

STEP = 5e-4  # s
RECORD = ("compensator.F_f", "compensator.F_mean", "compensator.z")


def velocity(n: int) -> np.ndarray:
    """Return a velocity [m/s] that crosses zero, creeps and runs fast."""
    t = np.arange(n) * STEP
    return 0.04 * np.sin(40 * t) * np.cos(3 * t) + 2e-4 * np.sin(7 * t)


def test_without_hold_the_velocity_of_a_step_is_the_mean_of_its_ends(alone):
    v = velocity(401)
    with alone("compensator", RECORD, step=STEP, stop=0.2) as simulation:
        middle = simulation.run(inputs={"v": v}, parameters={"compensator.hold": False})
        means = np.append(0.5 * (np.append(v[0], v[:-2]) + v[:-1]), 0.0)
        held = simulation.run(inputs={"v": means})
    np.testing.assert_allclose(
        middle["compensator.F_mean"], held["compensator.F_mean"], rtol=0, atol=1e-12
    )
    assert np.ptp(middle["compensator.F_mean"]) > 1.0


def test_lead_advances_the_velocity(alone):
    """A ramp a t with the lead T is the ramp a (t + T)."""
    with alone("compensator", RECORD, step=STEP, stop=0.1) as simulation:
        ramp = 0.5 * (simulation.time - 0.05)
        early = simulation.run(inputs={"v": ramp}, parameters={"compensator.lead": 2e-3})
        shifted = simulation.run(inputs={"v": ramp + 0.5 * 2e-3})
        plain = simulation.run(inputs={"v": ramp})
    for name in ("compensator.F_mean", "compensator.F_f"):
        assert abs(plain[name] - shifted[name])[40:].max() > 1.0
        np.testing.assert_allclose(early[name][40:], shifted[name][40:], rtol=0, atol=1e-8)


def test_viscous_term_of_equation_5(alone):
    v = velocity(401)
    with alone("compensator", RECORD, step=STEP, stop=0.2) as simulation:
        without = simulation.run(inputs={"v": v})
        result = simulation.run(inputs={"v": v}, parameters={"compensator.b": 30.0})
    extra = result["compensator.F_mean"] - without["compensator.F_mean"]
    np.testing.assert_allclose(extra[1:], 30.0 * v[:-1], atol=1e-12)


@settings(derandomize=True, deadline=None, max_examples=60, database=None)
@given(
    p=contacts,
    step=st.floats(-5.0, -2.0).map(lambda e: 10.0**e),
    amplitude=st.floats(-5.0, 0.0).map(lambda e: 10.0**e),
    start=st.floats(-3.0, 3.0),
    hold=st.booleans(),
)
def test_stable_for_every_parameter_vector_and_step(fmus, p, step, amplitude, start, hold):
    """Issue 2: 0.1 x .. 100 x Table 2, 1e-5 .. 1e-2 s: the bristle never leaves its reach."""
    reach = max(p["F_s"], p["F_c"]) / p["sigma_0"]
    system = cosim.System()
    system.add("compensator", fmus / "compensator.fmu", {**p, "z": start * reach, "hold": hold})
    system.expose("v", "compensator.v")
    with system.prepare(step=step, stop=300 * step, record=RECORD) as simulation:
        n = np.arange(301)
        result = simulation.run(inputs={"v": amplitude * np.sin(0.21 * n) * np.cos(0.013 * n)})
    assert np.isfinite(result.values).all()
    bound = max(abs(start), 1.0) * reach
    assert abs(result["compensator.z"]).max() <= bound * (1 + 1e-12)
    rate = amplitude * (1 + bound / (min(p["F_s"], p["F_c"]) / p["sigma_0"]))
    force = p["sigma_0"] * bound + p["sigma_1"] * rate
    assert abs(result["compensator.F_mean"]).max() <= force * (1 + 1e-9)
