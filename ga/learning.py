"""Learning: ask, evaluate, tell, until the algorithm has had enough."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from functools import partial

from ga.algorithm import GeneticAlgorithm
from ga.arrays import Array
from ga.errors import CandidateFailed, NothingLearned
from ga.generation import Candidate

Evaluate = Callable[[Array], float]
"""values (k,), in the genes' units -> cost, 0 .. inf; raises CandidateFailed if it has none"""


@dataclass(frozen=True)
class Learned:
    """What a run found.

    Parameters
    ----------
    best : the best candidate
    parameters : the same by name, in the genes' units
    stopped : why the run ended
    """

    best: Candidate
    parameters: dict[str, float]
    stopped: str


def learn(
    algorithm: GeneticAlgorithm,
    evaluate: Evaluate,
    executor: Executor | None = None,
    on_generation: Callable[[GeneticAlgorithm], object] | None = None,
) -> Learned:
    """Run `algorithm` until it stops. The result does not depend on the executor.

    Parameters
    ----------
    algorithm : new or resumed
    evaluate : cost of one candidate. Raising `CandidateFailed` makes the cost infinite and records
        the message; every other exception ends the run. Must pickle for an executor of processes.
    executor : any ``concurrent.futures`` executor; the caller's own thread by default
    on_generation : called after every generation, e.g. to write a checkpoint or move a bar

    Raises
    ------
    NothingLearned : every candidate of the first generation failed
    """
    while (stopped := algorithm.stopped) is None:
        outcomes = _evaluate_all(algorithm.ask(), evaluate, executor)
        algorithm.tell([cost for cost, _ in outcomes], [reason for _, reason in outcomes])
        if on_generation is not None:
            on_generation(algorithm)
        if algorithm.best.cost == float("inf"):
            raise NothingLearned(
                f"all {algorithm.evaluations} candidates failed, the start values among them; "
                f"the first because: {outcomes[0][1] or 'its cost is infinite'}"
            )
    best = algorithm.best
    parameters = dict(zip(algorithm.names, best.values.tolist(), strict=True))
    return Learned(best, parameters, stopped)


def _evaluate_all(
    population: Array, evaluate: Evaluate, executor: Executor | None
) -> list[tuple[float, str]]:
    """Cost and reason of every row, in order."""
    if executor is None:
        return [_outcome(partial(evaluate, row)) for row in population]
    futures: list[Future[float]] = [executor.submit(evaluate, row) for row in population]
    try:
        return [_outcome(future.result) for future in futures]
    finally:
        for future in futures:
            future.cancel()


def _outcome(judge: Callable[[], float]) -> tuple[float, str]:
    try:
        return float(judge()), ""
    except CandidateFailed as failure:
        return float("inf"), str(failure)
