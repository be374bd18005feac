"""Learning: ask, evaluate, tell, until the optimiser stops."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from stickslip.fmi.process import held
from stickslip.ga.algorithms.optimiser import Candidate, Optimiser
from stickslip.ga.errors import Interrupted, NothingLearned, StateError
from stickslip.ga.execution import checkpoint as files
from stickslip.ga.execution.evaluation import Evaluate, Evaluator

AnyOptimiser = TypeVar("AnyOptimiser", bound=Optimiser)


@dataclass(frozen=True)
class SearchResult:
    """The best candidate, its values by name in the genes' units, and why the run ended."""

    best: Candidate
    parameters: dict[str, float]
    stopped: str


def learn(
    algorithm: AnyOptimiser,
    evaluate: Evaluate,
    executor: Executor | None = None,
    on_generation: Callable[[AnyOptimiser], object] | None = None,
    *,
    checkpoint: Path | str | None = None,
    resume: bool = False,
    about: str = "",
) -> SearchResult:
    """Run `algorithm` until it stops. The result does not depend on the executor.

    Parameters
    ----------
    algorithm : a new optimiser, or one that was resumed
    evaluate : cost of one candidate. What it raises makes the cost infinite and is recorded as the
        reason, but not if the very first candidate, the start, raises anything else than
        `CandidateFailed`: this would be the fault of the set-up and ends the run, as do an
        ``OSError`` and what `evaluate` calls ``fatal``. Must pickle for workers in other processes.
    executor : see `executor`, or any of ``concurrent.futures``; the caller's own thread by default
    on_generation : called after every generation, e.g. to move a bar
    checkpoint : file that is written atomically after every generation
    resume : go on from `checkpoint`, if that exists, bit for bit as if nothing had happened
    about : what else the costs depend on; a checkpoint of something else is refused

    Raises
    ------
    NothingLearned : every candidate of the first generation failed
    StateError : the checkpoint exists and is not to be resumed, or is of another run
    Interrupted : Ctrl-C; the generations before are in the checkpoint
    """
    path = None if checkpoint is None else Path(checkpoint)
    if path is not None and path.exists():
        if not resume:
            advice = "resume it, or delete it to start again"
            raise StateError(f"{path}: holds an earlier learning run; {advice}")
        state = files.read(path, about)
        try:
            algorithm.replay(state)
        except StateError as error:
            raise StateError(f"{path}: {error}") from None

    def keep(algorithm: AnyOptimiser) -> None:
        if path is not None:
            files.write(path, algorithm.state(), about)
        if on_generation is not None:
            on_generation(algorithm)

    try:
        stopped = _run(algorithm, evaluate, executor, keep)
    except KeyboardInterrupt:
        raise Interrupted(path, algorithm.generation, algorithm.evaluations) from None
    best = algorithm.best
    parameters = dict(zip(algorithm.names, best.values.tolist(), strict=True))
    return SearchResult(best, parameters, stopped)


def _run(
    algorithm: AnyOptimiser,
    evaluate: Evaluate,
    executor: Executor | None,
    on_generation: Callable[[AnyOptimiser], object],
) -> str:
    evaluator = Evaluator(evaluate, executor)
    try:
        while (stopped := algorithm.stopped) is None:
            begins = algorithm.generation == 0
            outcomes = evaluator.outcomes(algorithm.ask(), algorithm.ahead, begins=begins)
            with held():  # the checkpoint has what the optimiser was told
                algorithm.tell([cost for cost, _ in outcomes], [reason for _, reason in outcomes])
                if algorithm.best.cost == float("inf"):
                    raise NothingLearned(
                        f"all {algorithm.evaluations} candidates failed, the start values among "
                        f"them; the first because: {outcomes[0][1] or 'its cost is not finite'}"
                    )
                on_generation(algorithm)
    finally:
        evaluator.dismiss()
    return stopped
