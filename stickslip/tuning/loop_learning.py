"""Genetic learning of the velocity loop: gains, feedforward and observer, together.

No regression finds them: what is best on the drive as it is can be the worst on one whose friction
has changed. So a candidate runs a motion on the drive, and on models of it, FMUs whose friction is
less and more, as no one can command on a drive. What counts of each kind of motion is the error
relative to that of the reference, a PI controller tuned without any model of friction, and of the
force its change from sample to sample; the largest counts most.

The drive shows its encoder only, and a loop that follows the steps of its encoder seems to track
well. So the velocity that counts is blended from encoder and motor force.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from stickslip import cosim, ga
from stickslip.identification.criteria.runs import Closing
from stickslip.servo.axis import ControlError
from stickslip.servo.measurement import Array
from stickslip.thresholds import kept
from stickslip.tuning.drive_model import PROBES, DriveModel, start_model
from stickslip.tuning.loop_runs import (
    FEEDFORWARD,
    GENES,
    PLAIN,
    LoopBench,
    LoopRuns,
    TunedLoop,
    by_kind,
)
from stickslip.tuning.search import Finalist, Ratios, best_of, choose, mean_of, search

LEVELS = (0.7, 1.3)  # friction of the models over the drive's own: temperature and wear
QUIET = 0.75  # weight of the change of the force, for heat and noise, beside an error
EVALUATIONS = 300  # candidates in a search; docs/measurements/loop-tuning.md shows others
REPEATS = 3
JITTER = 1e-4  # how often, and how much, their genes change in between
FORCE = "change of the force"


@dataclass(frozen=True)
class LoopStudy(LoopBench):
    """What learning of the loop needs, and nothing of the drive but its rig."""

    models: Sequence[DriveModel] = ()  # see ``fit_models``; by default of the identified friction
    algorithm: str = "cma"  # one of ``ga.ALGORITHMS``
    seed: int = 0  # of the search
    limits: ga.Limits = field(default_factory=lambda: ga.Limits(evaluations=EVALUATIONS))

    def optimiser(self) -> ga.Optimiser:
        """Return what searches."""
        problem = ga.Problem(list(GENES))
        return ga.optimiser(self.algorithm, problem, self.limits, seed=self.seed)


@dataclass(frozen=True)
class LearnedLoop:
    """A loop that was learned, or what is used instead."""

    seed: int
    tuned: TunedLoop  # the loop
    genes: Mapping[str, float]  # of which it is made
    # ``learned``, or where no candidate is as good as the reference in everything ``feedforward``,
    # the reference with the feedforward, or ``reference``
    chosen: str
    cost: float  # when it was chosen
    ratios: Ratios  # when it was chosen
    Ms: float  # its peak sensitivity
    evaluations: int  # candidates
    runs: int  # of the drive, with those for its models
    algorithm: ga.Optimiser  # what searched


@dataclass(frozen=True)
class _Case:
    """The drive, or a model with some friction."""

    level: float
    runs: LoopRuns
    # parameters of the model's FMU by name
    values: Mapping[str, float] = field(default_factory=dict)


class LoopCost(Closing):
    """The cost of a candidate: the mean of its ratios to the reference, with the power ``POWER``.

    It pickles; each worker prepares the loops of the drive and of the models when it runs its
    first candidate. Use it in a ``with`` block.
    """

    fatal = (cosim.CosimError,)

    def __init__(self, study: LoopStudy) -> None:
        self.study, self._own = study, LoopRuns(study)
        self.v_cmd = self._own.v_cmd
        self._cases = [_Case(1.0, self._own)]
        for model in study.models or [start_model(study, study.rig.law.name)]:
            values = {level: model.parameters(study, level) for level in LEVELS}
            runs = LoopRuns(study, model.law, tuple(values[LEVELS[0]]))
            self._cases += [_Case(level, runs, values[level]) for level in LEVELS]
        self._reference = self._errors(study.loop(PLAIN))

    def ratios(self, tuned: TunedLoop) -> Ratios:
        """Return the errors of a loop, and the change of its force, relative to the reference.

        With other friction they count as at least those with the drive's own, which is measured,
        and where models differ, the largest counts. Raises CandidateFailed when a run fails.
        """
        ratios: Ratios = {}
        errors = self._errors(tuned)
        for case, own, reference in zip(self._cases, errors, self._reference, strict=True):
            for kind, error in own.items():
                known = [ratios.get(key, 0.0) for key in ((kind, 1.0), (kind, case.level))]
                ratios[kind, case.level] = max(error / reference[kind], *known)
        ratios[FORCE, 1.0] *= QUIET
        return ratios

    def _errors(self, tuned: TunedLoop) -> list[dict[str, float]]:
        """Return of drive and models the errors by motion; of the drive also force changes [N]."""
        errors = []
        for case in self._cases:
            runs, modelled = case.runs, case.runs is not self._own
            run = runs.run(tuned, case.values)
            v = run[f"{runs.drive}.v"] if modelled else runs.shown(run)
            errors.append(by_kind(runs.errors(v)))
            if not modelled:
                errors[0][FORCE] = float(np.std(np.diff(run["drive.F_m"])))
        return errors

    def __call__(self, values: Array) -> float:
        """Return the cost of a candidate (k,); raise CandidateFailed where loop or run fails."""
        genes = {gene.name: value for gene, value in zip(GENES, values.tolist(), strict=True)}
        try:
            tuned = self.study.loop(genes)
        except ControlError as error:
            raise ga.CandidateFailed(str(error)) from error
        Ms = tuned.peak_sensitivity()
        if not Ms <= kept.SENSITIVITY:
            raise ga.CandidateFailed(f"Ms = {Ms:.3g}, expected at most {kept.SENSITIVITY:g}")
        return mean_of(self.ratios(tuned))

    def close(self) -> None:
        """Free the FMUs."""
        for case in self._cases:
            case.runs.close()


def what_is_left(study: LoopStudy) -> float:
    """Return the geometric mean of the ratios of a loop such as a search tries.

    It tells which of two feedforwards serves better; the cost does not, because a single ratio
    above 1 decides it. It is infinite where a run fails.
    """
    with LoopCost(study) as cost:
        try:
            ratios = cost.ratios(study.loop(PROBES[-1]))
        except ga.CandidateFailed:
            return float("inf")
    return float(np.exp(np.mean(np.log(list(ratios.values())))))


def learn_loop(
    study: LoopStudy,
    on_generation: Callable[[ga.Optimiser], object] | None = None,
    workers: int = 1,
) -> LearnedLoop:
    """Search the loop, run the best candidates again, and choose; raise what ``ga.learn`` does."""
    algorithm = study.optimiser()
    with LoopCost(study) as cost:
        search(algorithm, cost, workers, on_generation)
        return _choose(study, cost, algorithm)


def _choose(study: LoopStudy, cost: LoopCost, algorithm: ga.Optimiser) -> LearnedLoop:
    """Run the best candidates again, and what is simpler; return the cheapest."""
    tried = [*(("learned", genes) for genes in best_of(algorithm)), ("feedforward", FEEDFORWARD)]
    tried.append(("reference", PLAIN))
    rng = np.random.default_rng(study.seed)
    measured = [(name, genes, _typical(study, cost, genes, rng)) for name, genes in tried]
    one = choose([Finalist(*each, cost=mean_of(each[2])) for each in measured])
    tuned, evaluations = study.loop(one.genes), algorithm.evaluations
    return LearnedLoop(
        study.seed,
        tuned,
        one.genes,
        one.name,
        cost=one.cost,
        ratios=one.ratios,
        Ms=tuned.peak_sensitivity(),
        evaluations=evaluations,
        runs=(len(PROBES) if study.models else 0) + 1 + evaluations + REPEATS * len(tried),
        algorithm=algorithm,
    )


def _typical(
    study: LoopStudy, cost: LoopCost, genes: Mapping[str, float], rng: np.random.Generator
) -> Ratios:
    """Return the median ratios of repeated runs."""
    every = []
    for _ in range(REPEATS):
        change = np.exp(JITTER * rng.standard_normal(len(genes)))
        changed = {name: value * x for (name, value), x in zip(genes.items(), change, strict=True)}
        every.append(cost.ratios(study.loop(changed)))
    return {key: float(np.median([one[key] for one in every])) for key in every[0]}
