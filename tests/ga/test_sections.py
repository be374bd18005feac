"""Sections: exact where genes act independently, corrected where they do not."""

import numpy as np
import pytest

from stickslip.ga.operators.surrogates import Sections


def separable(string):
    """Return a sum over genes, each with several minima; the lowest, 0, at 0.7."""
    away = 10 * (string - 0.7)
    return float(np.sum(away**2 + 5 * (1 - np.cos(2 * np.pi * away))))


def searched(cost, start, generations, children=4, seed=0):
    """Return every candidate and its cost, the best one moved to after each generation."""
    rng = np.random.default_rng(seed)
    best, lowest = np.array(start), cost(np.array(start))
    sections, rows = Sections(best, lowest), []
    for _ in range(generations):
        strings = sections.propose(children, rng)
        costs = [cost(string) for string in strings]
        for string, value in zip(strings, costs, strict=True):
            sections.add(string, value)
            rows.append((string, value))
        if min(costs) < lowest:
            lowest, best = min(costs), strings[int(np.argmin(costs))]
            sections.move(best, lowest)
    return sections, rows


def test_a_sum_of_many_valleys_is_solved_gene_by_gene():
    """The grid of its minima has 11 ** 5 points."""
    _, rows = searched(separable, np.full(5, 0.13), 80)
    assert min(cost for _, cost in rows) < 1e-3


def test_children_change_one_gene_in_turn_and_stay_in_range():
    sections = Sections(np.full(3, 0.5), 1.0)
    children = sections.propose(7, np.random.default_rng(0))
    changed = children != 0.5
    assert (changed.sum(axis=1) == 1).all()
    np.testing.assert_array_equal(changed.argmax(axis=1), np.arange(7) % 3)
    assert ((children >= 0) & (children <= 1)).all()


def test_what_improves_two_genes_apart_is_put_together():
    sections = Sections(np.array([0.5, 0.5, 0.5]), 5.0)
    sections.add(np.array([0.2, 0.5, 0.5]), 4.0)
    sections.add(np.array([0.5, 0.9, 0.5]), 3.0)
    rng = np.random.default_rng(0)
    np.testing.assert_array_equal(sections.propose(1, rng)[0], [0.2, 0.9, 0.5])
    sections.add(np.array([0.2, 0.9, 0.5]), 30.0)  # the genes do not act independently
    assert not np.array_equal(sections.propose(1, rng)[0], [0.2, 0.9, 0.5])


@pytest.mark.parametrize("cost", [np.inf, 1e300])
def test_what_fails_is_avoided(cost):
    def half(string):
        return cost if string[0] > 0.6 else float((string[0] - 0.55) ** 2)

    _, rows = searched(half, np.array([0.1]), 40)
    assert min(value for _, value in rows) < 1e-8


def test_costs_that_differ_by_the_smallest_number_are_no_obstacle():
    """A wished improvement below it would round to nothing."""
    sections = Sections(np.array([0.5]), 0.0)
    sections.add(np.array([0.25]), 5e-324)
    children = sections.propose(50, np.random.default_rng(0))
    assert ((children >= 0) & (children <= 1)).all()
