"""From the first generation to the next: initial strings, crossover, mutation, and bounds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stickslip.ga.algorithms.settings import Settings
from stickslip.ga.arrays import Array
from stickslip.ga.operators.crossover import CROSSOVERS
from stickslip.ga.operators.mutation import MUTATIONS
from stickslip.ga.operators.surrogates import Origins


def first_generation(start: Array, settings: Settings, rng: np.random.Generator) -> Array:
    """Draw the strings of the first generation: the start, some around it, the rest anywhere.

    Parameters
    ----------
    start : string of the identified values, shape (k,)

    Returns
    -------
    ndarray, shape (population, k); may leave [0, 1] around the start

    Source
    ------
    Paper, Step 1.
    """
    others = settings.population - 1
    near = round(settings.near_share * others)
    around = start + settings.near_spread * rng.standard_normal((near, start.size))
    anywhere = rng.random((others - near, start.size))
    return np.vstack([start, around, anywhere])


def breed(
    strings: Array, costs: Array, rates: Array, settings: Settings, rng: np.random.Generator
) -> Array:
    """Return children for the places outside the elite.

    Parameters
    ----------
    strings : the generation, best first, shape (n, k)
    costs : of the generation, shape (n,)
    rates : of the children's mutation, shape (n - elites, 1)

    Returns
    -------
    ndarray, shape (n - elites, k); may leave [0, 1]

    Source
    ------
    Paper, Step 4.
    """
    children = CROSSOVERS[settings.crossover](strings, costs, settings, rng)
    return MUTATIONS[settings.mutation](children, strings, rates, rng)


@dataclass(frozen=True)
class Brood:
    """Children, in the order of the places that they compete for.

    Parameters
    ----------
    strings : what the operators work on, shape (n, k), 0 .. 1
    values : what is evaluated, shape (n, k), in the genes' units
    rates : of their mutation, shape (n, 1)
    origins : where each comes from, shape (n,), see `stickslip.ga.operators.surrogates`
    """

    strings: Array
    values: Array
    rates: Array
    origins: Origins
