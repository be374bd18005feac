"""Which parents the operators of the paper and of differential evolution choose."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stickslip import ga
from stickslip.ga.operators.breeding import arithmetic, differential

N = 20
LABELS = np.arange(N, dtype=float)[:, np.newaxis]  # a string names its candidate


def test_parents_are_drawn_in_proportion_to_their_fitness():
    """Where none is crossed, children are copies: of each as many as the inverse of its cost."""
    settings = replace(ga.PAPER, population=N, k1=0.0, k2=0.0)
    costs = np.linspace(1.0, 20.0, N)
    rng = np.random.default_rng(0)
    drawn = [arithmetic(LABELS, costs, settings, rng) for _ in range(2000)]
    counts = np.bincount(np.concatenate(drawn).astype(int).ravel(), minlength=N)
    share = (1.0 / costs) / (1.0 / costs).sum()
    deviation = np.sqrt(counts.sum() * share)
    assert abs(counts - counts.sum() * share).max() < 4.5 * deviation.max()
    assert np.mean(((counts - counts.sum() * share) / deviation) ** 2) < 2.0


def test_children_of_a_pair_lie_between_them_and_keep_their_mean():
    settings = replace(ga.PAPER, population=N, k1=1.0, k2=1.0)
    children = arithmetic(LABELS, np.full(N, 3.0), settings, np.random.default_rng(1))
    first, second = children[0::2], children[1::2]
    assert ((children >= 0) & (children <= N - 1)).all()
    both = (first[: len(second)] + second).ravel()  # of labels, which are whole numbers
    np.testing.assert_allclose(both, np.round(both), atol=1e-9)
    assert np.ptp(first % 1.0) > 0.1


def test_a_difference_is_of_two_others(monkeypatch):
    """The parent itself is not among them; the origin is the best one in 70 % of all children."""
    monkeypatch.setattr("stickslip.ga.operators.breeding.STRETCH", (1.0, 1.0))
    settings = replace(ga.DEFAULT, population=N, crossover_rate=1.0)
    strings = 3.0 ** np.arange(N)[:, np.newaxis]  # so that a child shows what it is the sum of
    rng, n = np.random.default_rng(2), np.arange(N)
    origin, plus, minus = (axis.ravel() for axis in np.meshgrid(n, n, n, indexing="ij"))
    sums = 3.0**origin + 3.0**plus - 3.0**minus
    best = []
    for _ in range(40):
        children = differential(strings, np.zeros(N), settings, rng)
        for place, child in enumerate(children[:, 0], start=settings.elites):
            found = (sums == child) & (plus != minus) & (plus != place) & (minus != place)
            assert found.any()
            best.append(bool((origin[found] == 0).any()))
    assert np.mean(best) == pytest.approx(0.7, abs=0.08)
