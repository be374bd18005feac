"""Genetic learning of the velocity loop: gains, feedforward and observer, together.

No regression finds them: what is best on the drive as it is can be the worst on one whose friction
has changed. So a candidate runs a motion on the drive, and on two models of it, FMUs of what was
identified, whose friction is less and more, as no one can command on a drive. What counts of each
kind of motion is the error relative to that of the reference, a PI controller tuned without any
model of friction, and of the force its change from sample to sample; the largest counts most.

The drive shows its encoder only, and a loop that follows the steps of its encoder seems to track
well. So the velocity that counts is that of a model, plus what encoder and motor force of the drive
show more than those of the model with the identified friction, in proportion to the friction.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from threadpoolctl import threadpool_limits

from stickslip import cosim, ga, models
from stickslip.evaluation.motions import Motion, Stroke, strokes
from stickslip.evaluation.validation import covered
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.axis import ControlError
from stickslip.servo.measurement import Array, blended_velocity
from stickslip.servo.paper_commands import REGION
from stickslip.servo.systems import Feed, build_loop
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.tuning.execution import Execution
from stickslip.tuning.loop_genes import CHAIN, FEEDFORWARD, GENES, PLAIN, TunedLoop, tuned_loop

LEVELS = (0.7, 1.3)
"""Friction of the models, relative to that identified: what temperature and wear change."""
STEEPER = 2.0
"""Exponent of the Stribeck curve of the model with more friction, where the law has one: its curve
falls faster than that identified, and a loop that is too soft sticks and slips on it. Without it
a drive with this exponent was left with 1.5 to 1.7 times the error of the reference."""
LIMIT = 1.98
"""Largest peak sensitivity Ms of a candidate. Textbooks allow 2.0, by which the gain margin is at
least 2 and the phase margin 29 degrees; 1 % is left for the error of the identified mass."""
POWER = 8
"""Exponent of the mean over the ratios: with 8, one that is a quarter smaller than the largest
counts a tenth as much as it."""
QUIET = 0.75
"""Weight of the change of the force, which costs heat and noise, beside that of an error."""
EVALUATIONS = 150
"""Candidates in a search: docs/measurements/loop-tuning.md shows what fewer and more give."""
FINALISTS = 3
"""Best candidates that are run again."""
REPEATS = 3
JITTER = 1e-4
"""How often, and by how much their genes change in between: as no drive runs twice alike."""
NO_WORSE = 1.02
"""Largest ratio to the reference, of any error and of the force, with which a loop is taken: runs
from other places within a step of the encoder scatter by 1 to 5 %, medians of three by 1.6 %."""
MODEL = "model"
"""Name of the model of the drive in a loop, and of its FMU."""
FORCE = "change of the force"

Ratios = dict[tuple[str, float], float]
"""By kind of motion, or ``FORCE``, and friction."""


def training_motion() -> Motion:
    """Return what a candidate runs: the kinds of motion of the validation, at other speeds.

    Errors of fast starts and reversals count where the paper evaluates them.
    """
    back, again = (1, -1, 1), (1, -1, 1, -1)
    kinds = [
        *(
            ("moves", v, again, Stroke(1.0, 0.025, 0.0, 0.1, 0.15))
            for v in (1.6e-4, 2.4e-4, 6e-4, 1.6e-3)
        ),
        *(("slow reversals", v, back, Stroke(1.0, 0.2, 0.0, 0.0, 0.2)) for v in (4e-4, 1.6e-3)),
        *(
            ("creep", v, back[:2], Stroke(1.0, 5e-3, 0.1 + 1e-4 / v, 0.1, 0.1 + 1e-4 / v))
            for v in (1.2e-4, 4e-4, 1.4e-3)
        ),
        ("fast", 0.02, back, Stroke(1.0, 0.3, 0.0, 0.0, 0.0)),
    ]
    moves = [
        (f"{kind}, {1e3 * v:g} mm/s", replace(stroke, speed=sign * v))
        for kind, v, signs, stroke in kinds
        for sign in signs
    ]
    motion = strokes("training", "What a candidate runs.", moves)
    regions = {
        name: tuple((t + REGION[0], t + REGION[1]) for t, _ in spans) if "fast" in name else spans
        for name, spans in motion.regions.items()
    }
    return replace(motion, regions=regions)


def errors_by_kind(motion: Motion, v_cmd: Array, v: Array, T_s: float) -> dict[str, float]:
    """Return RMS errors of a velocity (n,) relative to the command, by kind of motion."""
    t = np.asarray(np.arange(len(v)) * T_s)
    squares: dict[str, list[float]] = {}
    for region, spans in motion.regions.items():
        inside = covered(t, spans)
        error = float(np.mean((v - v_cmd)[inside] ** 2))
        size = float(np.mean(v_cmd[inside] ** 2))
        squares.setdefault(region.split(",")[0], []).append(error / size)
    return {kind: float(np.sqrt(np.mean(of))) for kind, of in squares.items()}


@dataclass(frozen=True)
class LoopStudy:
    """What learning of the loop needs, and nothing of the drive but its rig.

    Attributes
    ----------
    reference : the loop whose gains are tuned without a model, see ``servo/tuned_pi.py``
    friction : parameters of the law, as identified, by name
    algorithm : one of ``ga.ALGORITHMS``
    seed : of the search
    """

    rig: FmuRig
    reference: VelocityLoop
    friction: Mapping[str, float]
    feed: Feed = "nominal"
    algorithm: str = "cma"
    seed: int = 0
    limits: ga.Limits = field(default_factory=lambda: ga.Limits(evaluations=EVALUATIONS))

    def loop(self, genes: Mapping[str, float]) -> TunedLoop:
        """Return the loop of a candidate."""
        rig = self.rig
        return tuned_loop(genes, self.reference, rig.law, self.friction, rig.datasheet)

    def optimiser(self) -> ga.Optimiser:
        """Return what searches."""
        problem = ga.Problem(list(GENES))
        return ga.optimiser(self.algorithm, problem, self.limits, seed=self.seed)


@dataclass(frozen=True)
class LearnedLoop:
    """A loop that was learned, or what is used instead.

    Attributes
    ----------
    tuned : the loop
    genes : of which it is made
    chosen : ``learned``, or where no candidate is as good as the reference in everything
        ``feedforward``, the reference with the feedforward, or ``reference``
    cost, ratios : as they were measured when it was chosen
    Ms : its peak sensitivity
    evaluations : candidates
    runs : of the drive
    algorithm : what searched
    """

    seed: int
    tuned: TunedLoop
    genes: Mapping[str, float]
    chosen: str
    cost: float
    ratios: Ratios
    Ms: float
    evaluations: int
    runs: int
    algorithm: ga.Optimiser


class LoopCost:
    """The cost of a candidate: the mean of its ratios to the reference, with the power ``POWER``.

    It pickles; each worker prepares the loops of the drive and of the models when it runs its
    first candidate. Use it in a ``with`` block.
    """

    fatal = (cosim.CosimError,)

    def __init__(self, study: LoopStudy) -> None:
        self.study, rig = study, study.rig
        self.motion = training_motion()
        self.v_cmd = self.motion.command.sample(rig.samples(self.motion.duration))
        models.build_fmu("drive", rig.fmus, law=rig.law.name, called=MODEL)
        loop = study.loop(FEEDFORWARD)
        self._of_loop = list(loop.parameters())
        self._real = self._runner("drive", self._of_loop)
        self._models = self._runner(MODEL, [*self._of_loop, *self._of_model(1.0)])
        self.reference = self._errors(study.loop(PLAIN))

    def _runner(self, drive: str, names: list[str]) -> ga.SimulatedCost:
        study, rig = self.study, self.study.rig
        loop = study.reference.changed(m_ff=study.reference.axis.m)
        shown = ("x_enc", "F_m", *(["v"] if drive == MODEL else []))
        specification = cosim.Specification(
            build_loop(rig.fmus, loop, CHAIN, study.feed, drive=drive),
            step=rig.T_s,
            stop=(len(self.v_cmd) - 1) * rig.T_s,
            record=tuple(f"{drive}.{name}" for name in shown),
        )
        inputs = loop.commands(self.v_cmd)
        return ga.SimulatedCost(specification, names, _no_cost, inputs)

    def _of_model(self, level: float) -> dict[str, float]:
        """Return the parameters of the model with so many times the identified friction."""
        axis, sheet, law = self.study.reference.axis, self.study.rig.datasheet, self.study.rig.law
        known = {"m": axis.m, "b": axis.b, "tau_i": axis.tau_i, "u_max": sheet.peak_force}
        known |= {"encoder_step": sheet.encoder_step, **law.share(self.study.friction, level)}
        if "delta" in law.parameters:
            known["delta"] = STEEPER if level > 1.0 else law.parameters["delta"].start[0]
        return {f"{MODEL}.{name}": value for name, value in known.items()}

    def ratios(self, tuned: TunedLoop) -> Ratios:
        """Return the errors of a loop, and the change of its force, relative to the reference.

        With other friction they count as at least those with the drive's own, which is measured.

        Raises
        ------
        CandidateFailed
            When a run fails.
        """
        found = {key: x / self.reference[key] for key, x in self._errors(tuned).items()}
        return {(kind, level): max(x, found[kind, 1.0]) for (kind, level), x in found.items()}

    def _errors(self, tuned: TunedLoop) -> Ratios:
        """Return the errors by kind of motion and friction, and the change of the force [N]."""
        T_s, m, errors = self.study.rig.T_s, self.study.reference.axis.m, Ratios()
        values = list(tuned.parameters().values())
        run = self._real.result(np.array(values))
        shown, unlike = blended_velocity(run["drive.x_enc"], run["drive.F_m"], m, T_s), None
        for level in (1.0, *LEVELS):
            of = self._models.result(np.array([*values, *self._of_model(level).values()]))
            if unlike is None:
                measured = of[f"{MODEL}.x_enc"], of[f"{MODEL}.F_m"]
                unlike = shown - blended_velocity(*measured, m, T_s)
            v = of[f"{MODEL}.v"] + level * unlike
            kinds = errors_by_kind(self.motion, self.v_cmd, v, T_s)
            errors |= {(kind, level): error for kind, error in kinds.items()}
        errors[FORCE, 1.0] = float(np.std(np.diff(run["drive.F_m"])))
        return errors

    def __call__(self, values: Array) -> float:
        """Return the cost of a candidate (k,).

        Raises
        ------
        CandidateFailed
            When its loop is unstable or above the limit of Ms, or a run fails.
        """
        genes = {gene.name: value for gene, value in zip(GENES, values.tolist(), strict=True)}
        try:
            tuned = self.study.loop(genes)
        except ControlError as error:
            raise ga.CandidateFailed(str(error)) from error
        Ms = tuned.peak_sensitivity()
        if not Ms <= LIMIT:
            raise ga.CandidateFailed(f"Ms = {Ms:.3g}, expected at most {LIMIT:g}")
        return mean_of(self.ratios(tuned))

    def close(self) -> None:
        """Free the FMUs."""
        self._real.close()
        self._models.close()

    def __enter__(self) -> LoopCost:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _no_cost(_: cosim.Result) -> float:
    """Stand for a cost where runs alone are wanted."""
    return 0.0


def mean_of(ratios: Ratios) -> float:
    """Return the mean of ratios with the power ``POWER``; that of the force has ``QUIET``."""
    values = [(QUIET if kind == FORCE else 1.0) * ratio for (kind, _), ratio in ratios.items()]
    return float(np.mean(np.array(values) ** POWER) ** (1.0 / POWER))


def learn_loop(
    study: LoopStudy,
    on_generation: Callable[[ga.Optimiser], object] | None = None,
    execution: Execution | None = None,
) -> LearnedLoop:
    """Search the loop, run the best candidates again, and choose.

    Raises
    ------
    ga.NothingLearned, ga.StateError, ga.Interrupted
        As ``ga.learn``.
    """
    execution, algorithm = execution or Execution(), study.optimiser()
    one_thread = threadpool_limits(limits=1, user_api="blas")  # matrices are small, workers many
    with one_thread, LoopCost(study) as cost, execution.opened() as executor:
        ga.learn(
            algorithm,
            cost,
            executor,
            on_generation,
            checkpoint=execution.checkpoint,
            resume=execution.resume,
            about=f"loop, feed {study.feed}, {len(cost.v_cmd)} samples",
        )
        return _choose(study, cost, algorithm)


def _choose(study: LoopStudy, cost: LoopCost, algorithm: ga.Optimiser) -> LearnedLoop:
    """Run the best candidates again, and what is simpler; return the cheapest.

    Only what is worse than the reference in nothing counts; the reference itself always does.
    """
    names = [gene.name for gene in GENES]
    best = algorithm.history.drop_duplicates(names).nsmallest(FINALISTS, "cost")
    tried = [("learned", dict(zip(names, row, strict=True))) for row in best[names].to_numpy()]
    tried += [("feedforward", FEEDFORWARD), ("reference", PLAIN)]
    rng = np.random.default_rng(study.seed)
    found = [(chosen, genes, _typical(study, cost, genes, rng)) for chosen, genes in tried]
    good = [one for one in found[:-1] if max(one[2].values()) <= NO_WORSE]
    chosen, genes, ratios = min([*good, found[-1]], key=lambda one: mean_of(one[2]))
    tuned, evaluations = study.loop(genes), algorithm.evaluations
    return LearnedLoop(
        study.seed,
        tuned,
        genes,
        chosen,
        mean_of(ratios),
        ratios,
        Ms=tuned.peak_sensitivity(),
        evaluations=evaluations,
        runs=1 + evaluations + REPEATS * len(tried),
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
