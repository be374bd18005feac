"""The mutation rate follows what succeeds, if it is asked to."""

import numpy as np
import pytest

import ga
from ga.rates import MutationRate


def drawn(rate, n=2000):
    return rate.draw(n, np.random.default_rng(0))


def test_it_moves_to_the_rates_that_succeeded():
    rate = MutationRate(ga.Settings(mutation_rate=0.3))
    before = drawn(rate)
    assert before.mean() == pytest.approx(0.3, abs=0.01)
    assert (before >= 0).all()
    for _ in range(20):
        rates = drawn(rate)
        rate.follow(rates, rates[:, 0] > np.quantile(rates, 0.9))
    assert drawn(rate).mean() > 0.4
    level = drawn(rate)
    rate.follow(level, np.zeros(len(level), dtype=bool))
    np.testing.assert_array_equal(drawn(rate), level)


def test_a_fixed_rate_stays_and_draws_nothing():
    rate, rng = MutationRate(ga.PAPER), np.random.default_rng(1)
    state = rng.bit_generator.state
    rates = rate.draw(5, rng)
    rate.follow(rates, np.ones(5, dtype=bool))
    np.testing.assert_array_equal(rate.draw(5, rng), np.full((5, 1), ga.PAPER.mutation_rate))
    assert rng.bit_generator.state == state
