"""Optimisers by name, on the same problem."""

from __future__ import annotations

from stickslip.fmi.additions import modules_of
from stickslip.ga.algorithms.genetic import GeneticAlgorithm
from stickslip.ga.algorithms.optimiser import Optimiser
from stickslip.ga.algorithms.settings import DEFAULT, PRESETS, Limits
from stickslip.ga.errors import SettingsError
from stickslip.ga.problem.problem import Problem

modules_of(__package__)

OTHERS: dict[str, type[Optimiser]] = {
    method.kind: method
    for method in Optimiser.__subclasses__()
    if hasattr(method, "kind") and method is not GeneticAlgorithm
}
"""Each is a class in a module of this folder."""

EVALUATIONS = DEFAULT.population + (DEFAULT.generations - 1) * (DEFAULT.population - DEFAULT.elites)
"""What the presets spend: 802."""

ALGORITHMS = (*sorted(PRESETS), *OTHERS)
"""``default`` and ``paper``, our genetic algorithm; ``cma``, CMA-ES."""


def optimiser(
    name: str, problem: Problem, limits: Limits | None = None, seed: int = 0
) -> Optimiser:
    """Return a new optimiser.

    Parameters
    ----------
    name : one of `ALGORITHMS`
    problem : what to search
    limits : when to stop; by default after as many evaluations as the presets have
    seed : of all randomness

    Raises
    ------
    SettingsError : no such algorithm, or one that cannot search this problem
    """
    if name in PRESETS:
        return GeneticAlgorithm(problem.genes, PRESETS[name], seed, problem.repair, limits)
    if name not in OTHERS:
        raise SettingsError(f"no algorithm {name!r}; expected one of {', '.join(ALGORITHMS)}")
    return OTHERS[name](problem, limits or Limits(evaluations=EVALUATIONS), seed)
