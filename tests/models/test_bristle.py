"""The LuGre law, and the compensator that follows it: damping, lead, viscous force."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

H = 5e-4  # s
F_S, F_C, V_S, SIGMA_0, SIGMA_1 = 8.999, 5.999, 5.5697e-4, 3.9162e5, 4424.8
M, B = 5.557, 6.6135  # kg, N s/m
V_D = 2e-3  # m/s


def test_the_damping_fades_with_the_velocity(follow):
    """sigma_1 exp(-(v / v_d)^2) takes the place of sigma_1, and z is as before."""
    v = 3e-3 * np.sin(np.arange(400) * 0.05)
    whole, none = (follow("lugre", H, v, sigma_1=s)["F_mean"] for s in (SIGMA_1, 0.0))
    faded = follow("lugre", H, v, v_d=V_D)["F_mean"]
    share = np.exp(-((v / V_D) ** 2))
    np.testing.assert_allclose(faded, none + share * (whole - none), atol=1e-12)
    assert abs(whole - faded).max() > 1.0


def test_a_pushed_mass_against_radau(push):
    u = np.repeat([5.0, 12.0, -3.0, -14.0], 40)
    found, y = push("lugre", H, u, v_d=V_D), np.zeros(3)  # um, mm/s, um
    for k in range(0, len(u), 40):

        def motion(_: float, y: np.ndarray, force: float = u[k]) -> list[float]:
            v, z = 1e-3 * y[1], 1e-6 * y[2]
            dz = v - SIGMA_0 * abs(v) / (F_C + (F_S - F_C) * np.exp(-abs(v) / V_S)) * z
            damping = SIGMA_1 * np.exp(-((v / V_D) ** 2))
            return [v * 1e6, (force - B * v - SIGMA_0 * z - damping * dz) / M * 1e3, dz * 1e6]

        y = solve_ivp(motion, (0.0, 40 * H), y, "Radau", rtol=1e-9, atol=1e-9).y[:, -1]
        assert 1e3 * found["v"][k + 40] == pytest.approx(y[1], abs=2e-3)
        assert 1e6 * found["x"][k + 40] == pytest.approx(y[0], abs=0.01)
    assert np.ptp(found["v"]) > 0.03


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
