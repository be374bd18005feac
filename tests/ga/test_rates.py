"""Rates and shares follow what succeeds."""

import numpy as np
import pytest

from stickslip import ga
from stickslip.ga.operators.breeding import LEAST, MutationRate, Shares


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


def test_shares_follow_the_way_that_succeeds_more_often_and_none_dies_out():
    shares, rng = Shares((5, 1, 1)), np.random.default_rng(0)
    assert np.argmax(shares.shares) == 0
    chances = np.array([0.02, 0.4, 0.0])
    for _ in range(60):
        ways = shares.draw(7, rng)
        shares.follow(ways, rng.random(7) < chances[ways])
    assert shares.shares.sum() == pytest.approx(1)
    assert shares.shares[1] > 0.6
    assert (shares.shares >= LEAST).all()


def test_generations_without_success_teach_nothing():
    shares = Shares((1, 2))
    before = shares.shares
    shares.follow(np.array([0, 1, 1]), np.zeros(3, dtype=bool))
    np.testing.assert_array_equal(shares.shares, before)
