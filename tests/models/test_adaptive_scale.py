"""The slow scale of a feedforward: convergence in closed form, and when it stays."""

import numpy as np
import pytest

T = 5e-4  # s
PLAIN = {"tau_f": 0.0, "tau_i": 0.0, "b": 0.0, "m": 1e-6}
"""The friction is the motor force."""


@pytest.fixture
def scale(observe):
    """Return the scale after each sample (n,) and its force, of an axis that follows v (n,)."""

    def scale(v, friction, known=None, *, noise=0.0, step=0.0, F_m=None, **parameters):
        x = np.append(0.0, np.cumsum((v[:-1] + v[1:]) / 2) * T)[: len(v)]
        x = np.append(0.0, x[:-1])  # v_r is the velocity at the end of the period that begins
        rng = np.random.default_rng(1)
        x = x + noise * 1e-6 * rng.standard_normal(len(v))
        if F_m is None:
            F_m = friction * np.sign(np.append(0.0, v[:-1])) + noise * rng.standard_normal(len(v))
        signals = {
            "x_enc": np.round(x / step) * step if step else x,
            "F_m": F_m,
            "v_r": v,
            "F_in": np.sign(v) if known is None else known,
        }
        result = observe("adaptive_scale", signals, ("fmu.s", "fmu.F"), **parameters)
        return result["fmu.s"], result["fmu.F"]

    return scale


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("known", [1.0, 6.0])
def test_in_steady_sliding_the_error_falls_with_the_rate(scale, sign, known):
    """Friction is 1.4 times the feedforward: s = 1.4 - 0.4 exp(-rate t), but for a sample's lag."""
    n, rate = 20000, 0.3
    v = np.full(n, sign * 0.02)
    found, _ = scale(v, 1.4 * known, known * np.sign(v), rate=rate, **PLAIN)
    begin = np.flatnonzero(found != 1.0)[0]
    assert 20 < begin <= 22  # 0.2 mm at 10 um in a sample
    expected = 1.4 - 0.4 * np.exp(-rate * T * (np.arange(n) - begin + 1.0))
    np.testing.assert_allclose(found[begin:], expected[begin:], rtol=0, atol=0.4 * rate * T)


def test_it_stays_within_its_bounds(scale):
    v = np.full(4000, 0.02)
    for friction, bound in ((9.0, 1.5), (0.1, 0.7)):
        found, force = scale(v, friction, rate=10.0, least=0.7, most=1.5, **PLAIN)
        assert found[-1] == bound == force[-1]
    found, force = scale(v, 9.0, s_0=40.0, rate=0.0, **PLAIN)
    assert (found == 2.0).all()
    assert force[-1] == 2.0


def motions(n):
    t = np.arange(n) * T
    return {
        "rest": np.zeros(n),
        "slow": np.full(n, 9e-4),
        "short": 0.02 * np.sign(np.sin(2 * np.pi * 55.0 * t + 0.1)),
        "blocked": np.full(n, 0.02),
    }


@pytest.mark.parametrize("motion", ["rest", "slow", "short", "blocked"])
def test_without_sliding_nothing_changes_in_300_s(scale, motion):
    """With noise and a coarse encoder, and a motor force that no friction explains."""
    n = 600_001
    v, noise = motions(n)[motion], np.random.default_rng(2).standard_normal(n)
    known = np.where(v == 0.0, 6.0, 6.0 * np.sign(v))
    step = 1e3 if motion == "blocked" else 1e-5  # where it is blocked the encoder does not move
    found, force = scale(v, 0.0, known, F_m=20.0 + noise, noise=3.0, step=step)
    assert (found == 1.0).all()
    np.testing.assert_array_equal(force[1:], known[:-1])


@pytest.mark.parametrize("step", [0.0, 1e-5])
def test_noise_and_a_coarse_encoder_move_it_little_in_300_s(scale, step):
    """Momentum telescopes: what one sample of the encoder adds, the next one takes away."""
    t = np.arange(600_001) * T
    v = 0.02 * np.sin(2 * np.pi * 0.5 * t)
    inert = 5.557 * np.gradient(v, T) + 6.6135 * v
    F_m = np.append(0.0, (inert + 6.0 * np.sign(v))[:-1]) + np.random.default_rng(3).normal(
        0.0, 0.5, len(t)
    )
    found, _ = scale(v, 0.0, 6.0 * np.sign(v), F_m=F_m, noise=1.0, step=step, tau_i=0.0)
    assert np.abs(found[100_000:] - 1.0).max() < 0.01
