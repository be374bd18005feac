"""Mutation: a random change to a few genes, against premature agreement."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stickslip.ga.arrays import Array

Mutation = Callable[[Array, Array, Array, np.random.Generator], Array]
"""(children (m, k); strings of the population (n, k); rates (m, 1); rng) -> children (m, k)"""


def uniform(children: Array, strings: Array, rates: Array, rng: np.random.Generator) -> Array:
    """Give a mutated gene any value of its range.

    Source
    ------
    Paper, Step 4, part 3.
    """
    del strings  # wherever the population is
    mutated = rng.random(children.shape) < rates
    return np.where(mutated, rng.random(children.shape), children)


def spread(children: Array, strings: Array, rates: Array, rng: np.random.Generator) -> Array:
    """Move a mutated gene by about twice the population's standard deviation in that gene.

    The change is wide while the population is scattered and fine once it has closed in, so no
    schedule has to be guessed.
    """
    mutated = rng.random(children.shape) < rates
    change = 2 * strings.std(axis=0) * rng.standard_normal(children.shape)
    return np.where(mutated, children + change, children)


MUTATIONS: dict[str, Mutation] = {"uniform": uniform, "spread": spread}
