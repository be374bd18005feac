"""Which candidates survive, and what a cost is that was evaluated more than once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stickslip import ga
from stickslip.ga.algorithms.genetic import Generation

INF = float("inf")


def generation(costs):
    strings = np.arange(len(costs), dtype=float)[:, np.newaxis]
    return Generation.once(strings, strings, np.array(costs))


def test_a_repeated_cost_is_the_mean_of_all_its_runs():
    runs = np.random.default_rng(0).random((6, 3))
    kept = generation(runs[0])
    for n, costs in enumerate(runs[1:], start=2):
        kept = kept.averaged(costs[:2])
        np.testing.assert_allclose(kept.costs[:2], runs[:n, :2].mean(axis=0), rtol=1e-14)
    assert kept.costs[2] == runs[0, 2]
    assert kept.runs.tolist() == [6, 6, 1]


def test_a_child_takes_the_place_of_a_rival_that_is_not_better():
    settings = replace(ga.DEFAULT, population=6, survival="rival")
    parents = generation([1.0, 2.0, 3.0, 4.0, INF, INF])
    rivals = parents.costs[settings.elites :]
    children = generation(np.where(np.arange(len(rivals)) % 2, rivals, rivals + 1.0))
    wins = parents.winners(children, settings)
    assert wins.tolist() == (children.costs <= rivals).tolist()
    kept = parents.followed_by(children, wins)
    assert (kept.costs == parents.costs).all()  # those that win cost the same here
    everyone = replace(settings, survival="generational")
    assert parents.winners(children, everyone).all()
