"""The genetic algorithm over LuGre's five, judged by the recording."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor

import numpy as np

import ga
from stickslip.estimation.inverse import ImpliedCost, InverseModel
from stickslip.estimation.start import Start
from stickslip.measurement import Array
from stickslip.parameters import LUGRE, UNITS

SETTINGS = ga.Settings(population=12, generations=25, near_share=0.3, near_spread=0.15)


def genes(start: Start) -> list[ga.Gene]:
    """Return the five genes, logarithmic, over what the unknowns' bounds leave."""
    unknowns = start.unknowns
    low, high = unknowns.values(unknowns.lower), unknowns.values(unknowns.upper)
    low["F_s"] = low["F_c"]
    return [ga.Gene(name, low[name], high[name], start.line[name], UNITS[name]) for name in LUGRE]


def search(
    model: InverseModel,
    start: Start,
    seed: int,
    settings: ga.Settings = SETTINGS,
    executor: Executor | None = None,
    on_generation: Callable[[ga.GeneticAlgorithm], object] | None = None,
) -> ga.GeneticAlgorithm:
    """Let candidates imply a force, and keep those that come near the recorded one.

    m, b and F_0 follow from each candidate by least squares.

    Raises
    ------
    ga.NothingLearned
        When no candidate could be run.
    """
    algorithm = ga.GeneticAlgorithm(genes(start), settings, seed, ga.AtLeast("F_s", "F_c"))
    names = [f"compensator.{name}" for name in LUGRE]
    cost = ImpliedCost.of(model, start.line["delay"])
    with ga.SimulatedCost(model.specification, names, cost, model.inputs) as evaluate:
        ga.learn(algorithm, evaluate, executor, on_generation)
    return algorithm


def with_linear(model: InverseModel, start: Start, lugre: Array) -> dict[str, float]:
    """Return all values: LuGre's (5,) and the m, b and F_0 that suit them best."""
    values = {**start.line, **dict(zip(LUGRE, lugre.tolist(), strict=True))}
    if model.measures_friction:
        return values
    rest = model.residual({**values, "m": 0.0, "b": 0.0, "F_0": 0.0})
    found, *_ = np.linalg.lstsq(model.linear[model.used], rest, rcond=None)
    low = start.unknowns.values(start.unknowns.lower)
    values["m"], values["b"] = max(float(found[0]), low["m"]), max(float(found[1]), 0.0)
    values["F_0"] = float(found[2])
    return values
