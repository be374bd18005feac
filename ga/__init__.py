"""Learns the parameters of a simulated system with a genetic algorithm. It knows no friction.

The core works on plain arrays and needs nothing but numpy and pandas; only `SimulatedCost` runs
FMUs, and importing it imports cosim.

    algorithm = ga.GeneticAlgorithm(genes, ga.DEFAULT, seed=0)
    learned = ga.learn(algorithm, evaluate)

    GaError(Exception)
        SettingsError(ValueError)      a gene, a setting or a repair makes no sense
        CostError(ValueError)          costs do not fit the candidates asked
        StateError(ValueError)         a checkpoint of another problem, or none at all
        CallOrderError(RuntimeError)   ask and tell out of turn
        CandidateFailed                a candidate cannot be judged; raised by the cost
        NothingLearned                 every candidate of the first generation failed
"""

from typing import TYPE_CHECKING

from ga.adaptive import crossover_probability
from ga.algorithm import GeneticAlgorithm
from ga.errors import (
    CallOrderError,
    CandidateFailed,
    CostError,
    GaError,
    NothingLearned,
    SettingsError,
    StateError,
)
from ga.fitness import fitness
from ga.gene import Gene
from ga.generation import Candidate
from ga.learning import Learned, learn
from ga.repair import AtLeast
from ga.settings import DEFAULT, PAPER, PRESETS, Settings

if TYPE_CHECKING:
    from ga.candidates import SimulatedCost

__all__ = [
    "DEFAULT",
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
    "Learned",
    "NothingLearned",
    "Settings",
    "SettingsError",
    "SimulatedCost",
    "StateError",
    "crossover_probability",
    "fitness",
    "learn",
]


def __getattr__(name: str) -> object:
    """Import cosim when `SimulatedCost` is first asked for, not before."""
    if name == "SimulatedCost":
        from ga.candidates import SimulatedCost

        return SimulatedCost
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
