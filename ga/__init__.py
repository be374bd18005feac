"""Learns the parameters of a simulated system by trying them. It knows no friction.

The core works on plain arrays; only `SimulatedCost` runs FMUs, and importing it imports cosim.

    problem = ga.Problem(genes, repair)
    optimiser = ga.optimiser("default", problem, ga.Limits(evaluations=1000), seed=0)
    with ga.executor("processes", workers=4) as executor:
        learned = ga.learn(optimiser, evaluate, executor, checkpoint="run.json")

``default`` is for costs of one or many valleys, with noise or failures; ``paper`` is the algorithm
as published.
"""

from typing import TYPE_CHECKING

from stickslip.ga.algorithms.by_name import ALGORITHMS, OTHERS, optimiser
from stickslip.ga.algorithms.genetic import GeneticAlgorithm
from stickslip.ga.algorithms.optimiser import Candidate, Optimiser
from stickslip.ga.algorithms.settings import DEFAULT, PAPER, PRESETS, Limits, Settings
from stickslip.ga.errors import (
    CallOrderError,
    CandidateFailed,
    CostError,
    GaError,
    Interrupted,
    NothingLearned,
    SettingsError,
    StateError,
    WorkersLost,
)
from stickslip.ga.execution.executors import executor
from stickslip.ga.execution.learning import SearchResult, learn
from stickslip.ga.importance import importances
from stickslip.ga.operators.breeding import crossover_probability, fitness
from stickslip.ga.problem.problem import AtLeast, Gene, Problem

if TYPE_CHECKING:
    from stickslip.ga.problem.candidates import SimulatedCost

__all__ = [
    "ALGORITHMS",
    "DEFAULT",
    "OTHERS",
    "PAPER",
    "PRESETS",
    "AtLeast",
    "CallOrderError",
    "Candidate",
    "CandidateFailed",
    "CostError",
    "GaError",
    "Gene",
    "GeneticAlgorithm",
    "Interrupted",
    "Limits",
    "NothingLearned",
    "Optimiser",
    "Problem",
    "SearchResult",
    "Settings",
    "SettingsError",
    "SimulatedCost",
    "StateError",
    "WorkersLost",
    "crossover_probability",
    "executor",
    "fitness",
    "importances",
    "learn",
    "optimiser",
]


def __getattr__(name: str) -> object:
    """Import cosim when `SimulatedCost` is first asked for, not before."""
    if name == "SimulatedCost":
        from stickslip.ga.problem.candidates import SimulatedCost

        return SimulatedCost
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
