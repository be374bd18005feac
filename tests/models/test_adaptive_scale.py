"""The slow scale of a feedforward: when it stays."""

import numpy as np
import pytest

T = 5e-4  # s
N = 600_001  # samples in 300 s


@pytest.fixture
def scale(observe):
    """Return the scale after each sample (N,) and its force, of an axis that follows v (N,)."""

    def scale(v, known, F_m, *, noise, step, **parameters):
        x = np.append(0.0, np.cumsum((v[:-1] + v[1:]) / 2) * T)
        x = np.append(0.0, x[:-1])  # v_r is the velocity at the end of the period that begins
        x = x + noise * 1e-6 * np.random.default_rng(1).standard_normal(N)
        x_enc = np.round(x / step) * step if step else x
        signals = {"x_enc": x_enc, "F_m": F_m, "v_r": v, "F_in": known}
        result = observe("adaptive_scale", signals, ("fmu.s", "fmu.F"), **parameters)
        return result["fmu.s"], result["fmu.F"]

    return scale


MOTIONS = {
    "rest": np.zeros(N),
    "slow": np.full(N, 9e-4),
    "short": 0.02 * np.sign(np.sin(2 * np.pi * 55.0 * np.arange(N) * T + 0.1)),
    "blocked": np.full(N, 0.02),
}


@pytest.mark.parametrize("motion", MOTIONS)
def test_without_sliding_nothing_changes_in_300_s(scale, motion):
    """With noise and a coarse encoder, and a motor force that no friction explains."""
    v, noise = MOTIONS[motion], np.random.default_rng(2).standard_normal(N)
    known = np.where(v == 0.0, 6.0, 6.0 * np.sign(v))
    step = 1e3 if motion == "blocked" else 1e-5  # where it is blocked the encoder does not move
    found, force = scale(v, known, 20.0 + noise, noise=3.0, step=step)
    assert (found == 1.0).all()
    np.testing.assert_array_equal(force[1:], known[:-1])


@pytest.mark.parametrize("step", [0.0, 1e-5])
def test_noise_and_a_coarse_encoder_move_it_little_in_300_s(scale, step):
    """Momentum telescopes: what one sample of the encoder adds, the next one takes away."""
    v = 0.02 * np.sin(2 * np.pi * 0.5 * np.arange(N) * T)
    needed = 5.557 * np.gradient(v, T) + 6.6135 * v + 6.0 * np.sign(v)
    F_m = np.append(0.0, needed[:-1]) + np.random.default_rng(3).normal(0.0, 0.5, N)
    found, _ = scale(v, 6.0 * np.sign(v), F_m, noise=1.0, step=step, tau_i=0.0)
    assert np.abs(found[100_000:] - 1.0).max() < 0.01
