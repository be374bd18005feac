"""The global search over the parameters of the friction law."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from stickslip import ga
from stickslip.identification.criteria.inverse_model import ForceCost, InverseModel
from stickslip.identification.fitting.start import Start
from stickslip.servo.measurement import Array
from stickslip.work.execution import Execution

EVALUATIONS = 300  # enough to reach the basin of the minimum; a local fit follows
PATIENCE = 100


def problem(start: Start) -> ga.Problem:
    """Return a gene for each parameter of the law, logarithmic, between the bounds of the space."""
    space = start.space
    low, high = space.decode(space.lower), space.decode(space.upper)
    for name, bound in space.bounded.items():
        low[name] = low[bound]
    genes = [
        ga.Gene(name, low[name], high[name], start.line[name], unit=space.law.parameters[name].unit)
        for name in space.friction
    ]
    repairs = [ga.AtLeast(name, bound) for name, bound in space.bounded.items()]
    return ga.Problem(genes, repairs[0] if repairs else None)


@dataclass(frozen=True)
class Search:
    """How to search."""

    algorithm: str = "default"  # one of ``ga.ALGORITHMS``
    evaluations: int = EVALUATIONS  # at most
    # where candidates run, and the checkpoint
    execution: Execution = field(default_factory=Execution)


def search(
    model: InverseModel,
    start: Start,
    seed: int,
    how: Search,
    on_generation: Callable[[ga.Optimiser], object] | None = None,
) -> ga.Optimiser:
    """Search the parameters whose predicted force is nearest to the measured one.

    m, b and F_0 follow from each candidate by linear least squares.

    Raises
    ------
    ga.NothingLearned
        When no candidate could be run.
    ga.StateError
        When the checkpoint is of another run, or is there and not to be resumed.
    ga.Interrupted
        At Ctrl-C.
    """
    limits = ga.Limits(evaluations=how.evaluations, patience=PATIENCE)
    algorithm = ga.optimiser(how.algorithm, problem(start), limits, seed)
    names = [f"compensator.{name}" for name in start.space.friction]
    cost = ForceCost.of(model, start.line["delay"])
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
    """Return a hash of the recording."""
    content = np.concatenate([model.t, model.force, model.motion.v]).tobytes()
    return hashlib.sha256(content).hexdigest()


def solve_linear(model: InverseModel, start: Start, friction: Array) -> dict[str, float]:
    """Return all values: those of the law, and the m, b and F_0 of linear least squares."""
    values = {**start.line, **dict(zip(start.space.friction, friction.tolist(), strict=True))}
    if model.measures_friction:
        return values
    slides = model.slides[model.used]
    rest = model.residual({**values, "m": 0.0, "b": 0.0, "F_0": 0.0})[slides]
    found, *_ = np.linalg.lstsq(model.linear[model.used][slides], rest, rcond=None)
    low = start.space.decode(start.space.lower)
    values["m"], values["b"] = max(float(found[0]), low["m"]), max(float(found[1]), 0.0)
    values["F_0"] = float(found[2])
    return values
