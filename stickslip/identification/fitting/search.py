"""The global search over LuGre's five, judged by the recording."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from stickslip import ga
from stickslip.catalog.parameters import LUGRE, UNITS
from stickslip.identification.criteria.inverse_model import ImpliedCost, InverseModel
from stickslip.identification.fitting.start import Start
from stickslip.servo.measurement import Array
from stickslip.tuning.execution import Execution

EVALUATIONS = 300
"""The local fit that follows needs the valley only."""
PATIENCE = 100


def genes(start: Start) -> list[ga.Gene]:
    """Return the five genes, logarithmic, over what the unknowns' bounds leave."""
    unknowns = start.unknowns
    low, high = unknowns.values(unknowns.lower), unknowns.values(unknowns.upper)
    low["F_s"] = low["F_c"]
    return [ga.Gene(name, low[name], high[name], start.line[name], UNITS[name]) for name in LUGRE]


@dataclass(frozen=True)
class Search:
    """How to search.

    Attributes
    ----------
    algorithm : one of ``ga.ALGORITHMS``
    evaluations : at most
    execution : where candidates run, and the checkpoint
    """

    algorithm: str = "default"
    evaluations: int = EVALUATIONS
    execution: Execution = field(default_factory=Execution)


def search(
    model: InverseModel,
    start: Start,
    seed: int,
    how: Search,
    on_generation: Callable[[ga.Optimiser], object] | None = None,
) -> ga.Optimiser:
    """Let candidates imply a force, and keep those that come near the recorded one.

    m, b and F_0 follow from each candidate by least squares.

    Raises
    ------
    ga.NothingLearned
        When no candidate could be run.
    ga.StateError
        When the checkpoint is of another run, or is there and not to be resumed.
    ga.Interrupted
        At Ctrl-C.
    """
    problem = ga.Problem(genes(start), ga.AtLeast("F_s", "F_c"))
    limits = ga.Limits(evaluations=how.evaluations, patience=PATIENCE)
    algorithm = ga.optimiser(how.algorithm, problem, limits, seed)
    names = [f"compensator.{name}" for name in LUGRE]
    cost = ImpliedCost.of(model, start.line["delay"])
    with (
        ga.SimulatedCost(model.specification, names, cost, model.inputs) as evaluate,
        how.execution.opened() as executor,
    ):
        ga.learn(
            algorithm,
            evaluate,
            executor,
            on_generation,
            checkpoint=how.execution.checkpoint,
            resume=how.execution.resume,
            about=fingerprint(model),
        )
    return algorithm


def fingerprint(model: InverseModel) -> str:
    """Return what tells one recording from another."""
    content = np.concatenate([model.t, model.force, model.motion.v]).tobytes()
    return hashlib.sha256(content).hexdigest()


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
