"""Where a residual stands out: noise does not, what was added to it does."""

import numpy as np
import pytest

from stickslip.studies.learn.page import OUT, stretches

T = np.arange(0.0, 20.0, 5e-4)


@pytest.mark.parametrize("seed", range(5))
def test_only_what_was_added_to_noise_stands_out(seed):
    rng = np.random.default_rng(seed)
    noise = rng.normal(0.0, 1e-7, len(T)) * (1.0 + (np.sin(T) > 0.0))  # twice as loud at times
    assert not stretches(T, noise, np.ones(len(T)))
    bumps = sum(h * np.exp(-(((T - at) / 0.1) ** 2)) for at, h in ((8.0, -2e-6), (3.0, 5e-6)))
    first, second = stretches(T, noise + bumps, -0.5 * T)
    assert first.begin < 3.0 < first.end < second.begin < 8.0 < second.end
    assert first.peak == pytest.approx(5e-6, rel=0.2)
    assert second.peak == pytest.approx(-2e-6, rel=0.2)
    assert first.ratio > second.ratio > OUT
    assert second.speed == pytest.approx(4.0, rel=0.05)


def test_a_residual_of_nothing_has_no_stretches():
    assert not stretches(T, np.zeros(len(T)), T)
