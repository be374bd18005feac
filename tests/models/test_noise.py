"""Noise that is a function of seed, channel and count."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

import numpy as np
import pytest

N = 100_000


@pytest.fixture
def draw(library: ctypes.CDLL) -> Callable[..., np.ndarray]:
    def draw(seed: int = 0, channel: int = 0, n: int = N) -> np.ndarray:
        y = np.empty(n)
        library.probe_noise(
            ctypes.c_size_t(n), ctypes.c_double(seed), channel, y.ctypes.data_as(ctypes.c_void_p)
        )
        return y

    return draw


def test_mean_0_and_variance_1(draw):
    """Within five standard errors: 1 / sqrt(n), and sqrt((kurtosis - 1) / n) of the variance."""
    y = draw()
    assert abs(y.mean()) < 5 / np.sqrt(N)
    assert abs(y.var() - 1) < 5 * np.sqrt(1.9 / N)


def test_bell_shape(draw):
    """Twelve uniforms summed: no skew, kurtosis 3 - 1.2 / 12, and 68.3 % within one deviation."""
    y = draw()
    assert abs((y**3).mean()) < 5 * np.sqrt(15 / N)
    assert abs((y**4).mean() - 2.9) < 5 * np.sqrt(96 / N)
    assert abs((np.abs(y) < 1).mean() - 0.6785) < 0.01
    assert np.abs(y).max() <= 6


def test_same_seed_same_noise(draw):
    np.testing.assert_array_equal(draw(7), draw(7))


@pytest.mark.parametrize("other", [{"seed": 1}, {"channel": 1}, {"seed": 2**31 - 1}])
def test_seeds_and_channels_are_independent(draw, other):
    y, z = draw(), draw(**other)
    assert abs(np.corrcoef(y, z)[0, 1]) < 5 / np.sqrt(N)


def test_draws_are_independent_of_those_before(draw):
    y = draw(3)
    for lag in (1, 2, 7):
        assert abs(np.corrcoef(y[:-lag], y[lag:])[0, 1]) < 5 / np.sqrt(N)
