"""The LuGre observer: the feedforward without a correction, and what the correction does."""

from __future__ import annotations

import numpy as np
import pytest

from stickslip import cosim, models

T = 5e-4  # s
P = {v.name: v.start for v in models.load_model("lugre_observer").variables}


def run(fmus, name, signals, **parameters):
    system = cosim.System()
    system.add("fmu", fmus / f"{name}.fmu", parameters)
    for signal in signals:
        system.expose(signal, f"fmu.{signal}")
    stop = T * (len(next(iter(signals.values()))) - 1)
    with system.prepare(step=T, stop=stop, constant_step=True) as simulation:
        return simulation.run(inputs=signals)


def test_without_a_correction_it_is_the_feedforward_bit_for_bit(fmus):
    t = np.arange(2000) * T
    v = 0.03 * np.sin(30 * t) * np.cos(7 * t) + 1e-4
    noise = np.random.default_rng(1).normal(0.0, 1e-3, len(t))
    options = {"k_e": 0.0, "reference": True, "lead": 2e-4, "sigma_1": 3000.0, "delta": 2.0}
    found = run(fmus, "lugre_observer", {"x_enc": noise, "v_r": v}, **options)["fmu.F"]
    plain = {"hold": False, "lead": 2e-4, "sigma_1": 3000.0, "delta": 2.0}
    expected = run(fmus, "compensator", {"v": v}, **plain)["fmu.F_mean"]
    assert np.ptp(found) > 10.0
    assert found.tobytes() == expected.tobytes()


@pytest.mark.parametrize("share_1", [0.0, 1.0])
def test_at_constant_speeds_the_correction_is_a_share_of_the_steady_force(fmus, share_1):
    """Z ends where dz/dt is 0, at g / sigma_0 (1 - k_e e / v)."""
    v, v_r = 0.02, 0.018
    signals = {"x_enc": v * T * np.arange(800), "v_r": np.full(800, v_r)}
    found = run(fmus, "lugre_observer", signals, k_e=0.5, share_1=share_1)
    g = P["F_c"] + (P["F_s"] - P["F_c"]) * np.exp(-v / P["v_s"])
    steady = g * (1.0 - 0.5 * (v - v_r) / v)
    assert found["fmu.z_hat"][-1] == pytest.approx(steady / P["sigma_0"], rel=1e-9)
    if share_1:
        assert found["fmu.F"][-1] == pytest.approx(steady, rel=1e-9)


def test_at_rest_the_correction_integrates_up_to_a_limit(fmus):
    """It adds sigma_0 k_e to the integral gain and sigma_1 k_e to the proportional one."""
    signals = {"x_enc": np.zeros(400), "v_r": np.full(400, 1e-3)}
    found = run(fmus, "lugre_observer", signals, k_e=0.4)
    k = np.arange(20)
    expected = 0.4 * 1e-3 * (P["sigma_0"] * T * (k + 0.5) + P["sigma_1"])
    np.testing.assert_allclose(found["fmu.F"][1:21], expected, rtol=1e-9)
    assert found["fmu.z_hat"][-1] == 3.0 * P["F_s"] / P["sigma_0"]
