"""Models of the drive that err in a loop as the drive does.

What was identified explains the experiments, of which none is in a loop that is to be learned, and
a drive of another friction law errs otherwise. So the drive runs the training motion in a few
loops, and the friction law and parameters are found whose errors are those. Waveforms are no
measure: where a loop sticks and slips, two runs of one drive from other places within a step of the
encoder part.
"""

from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar
from threadpoolctl import threadpool_limits

from stickslip import cosim, ga, models
from stickslip.catalog.parameters import PAPER, friction_law, scaled_start
from stickslip.identification.criteria.runs import Closing
from stickslip.servo.measurement import Array
from stickslip.thresholds import kept
from stickslip.tuning.loop_runs import FEEDFORWARD, PLAIN, LoopBench, LoopRuns

PROBES = (
    PLAIN,
    FEEDFORWARD,
    PLAIN | {"K_p": 0.75, "K_i": 0.5, "m_ff": 0.5, "share": 0.7, "observed": 0.1},
)
"""Loops that the drive runs: the reference, and such as a search tries."""
NOISIEST = 0.5  # largest noise of the encoder of a model, in steps of it
STEEPER = 2.0
"""Exponent of the Stribeck curve with more friction of a model that was not fitted: of what was
identified the exponent is not known, and with this one, a usual one, the curve falls faster. On a
drive that has it, loops were taken that stick and slip, with 1.5 to 1.7 times the error of the
reference."""
LAWS = ("lugre", "elasto_plastic", "gms", "dahl", "coulomb_stribeck", "armstrong")
"""Laws of models. That of Leuven is left out, as it takes fifty times as long to run as LuGre."""
ROUNDS = (60, 300)
"""Candidates in the search of a law's parameters: of each law, and of the best ``FINALISTS``. After
60 the drive's own law is first or second (Armstrong, GMS, elasto-plastic); after 300 it has a
mismatch of 0.04 to 0.10, by chance of the search."""
FINALISTS = 2
WIDE = 4.0
"""By what factor a parameter may differ from its start: LuGre identifies 0.57 of the stiffness of a
drive of GMS friction, and 1.55 of one of Armstrong's."""


@dataclass(frozen=True)
class DriveModel:
    """Friction of a model of the drive."""

    law: str  # name
    friction: dict[str, float]  # its parameters by name, SI units
    noise: float = 0.0  # standard deviation of the noise of the encoder [m]
    mismatch: float = 0.0  # RMS of the logarithms of its errors relative to those of the drive
    fitted: bool = False  # whether it is of a search, or what was identified

    def parameters(self, bench: LoopBench, level: float) -> dict[str, float]:
        """Return the parameters of its FMU by name, with so many times its friction."""
        axis, sheet = bench.reference.axis, bench.rig.datasheet
        known = {"m": axis.m, "b": axis.b, "tau_i": axis.tau_i, "u_max": sheet.peak_force}
        known |= {"encoder_step": sheet.encoder_step, "noise_x": self.noise}
        known |= friction_law(self.law).share(self.friction, level)
        if level > 1.0 and not self.fitted and "delta" in known:
            known["delta"] = STEEPER
        return known


def start_model(bench: LoopBench, law: str) -> DriveModel:
    """Return a model with what was identified, and usual values of what its law has besides."""
    known = bench.friction
    deflection = known["F_c"] / known.get("sigma_0", PAPER["sigma_0"])
    friction = {
        name: known.get(name, scaled_start(one, known["F_c"], deflection))
        for name, one in friction_law(law).parameters.items()
        if len(one.start) == 1
    }
    return DriveModel(law, friction)


class Mismatch(Closing):
    """How unlike those of the drive the errors of a model are: the cost of a search.

    It pickles. Use it in a ``with`` block. The errors are those of the drive, see ``errors_of``.
    ``start`` is a model with what was identified, and the noise with which it errs most like it.
    """

    fatal = (cosim.CosimError,)

    def __init__(self, bench: LoopBench, law: str, errors: Array) -> None:
        self.bench, self._errors = bench, errors
        start = start_model(bench, law)
        self._runs = LoopRuns(bench, law, tuple(start.parameters(bench, 1.0)))
        self.start = self._noisy(start)
        limits = {one.name: one for one in models.load_model("drive", law).variables}
        self.genes = [
            ga.Gene(
                name,
                max(value / WIDE, limits[name].minimum or 0.0),
                min(value * WIDE, limits[name].maximum or np.inf),
                value,
                unit=limits[name].unit or "1",
            )
            for name, value in {**self.start.friction, "noise_x": self.start.noise}.items()
            if value > 0.0
        ]

    def model(self, values: Array) -> DriveModel:
        """Return the model of a candidate (k,)."""
        found = dict(self.start.friction)
        found |= {gene.name: x for gene, x in zip(self.genes, values.tolist(), strict=True)}
        noise = found.pop("noise_x", 0.0)
        for name, one in friction_law(self.start.law).parameters.items():
            if one.at_least:
                found[name] = max(found[name], found[one.at_least])
        return replace(self.start, friction=found, noise=noise, fitted=True)

    def __call__(self, values: Array) -> float:
        """Return the mismatch of a candidate (k,)."""
        return self.of(self.model(values))

    def of(self, model: DriveModel) -> float:
        """Return the mismatch of a model."""
        errors = errors_of(self._runs, model.parameters(self.bench, 1.0))
        return float(np.sqrt(np.mean(np.log(errors / self._errors) ** 2)))

    def _noisy(self, start: DriveModel) -> DriveModel:
        step = self.bench.rig.datasheet.encoder_step

        def mismatch(share: float) -> float:
            return self.of(replace(start, noise=share * step))

        try:
            most, quiet = NOISIEST, mismatch(0.0)
        except ga.CandidateFailed:  # a law whose FMU cannot run with such values
            return replace(start, mismatch=float("inf"))
        found = minimize_scalar(
            mismatch, bounds=(0.0, most), method="bounded", options={"xatol": 0.01, "maxiter": 12}
        )
        if found.fun < quiet:
            return replace(start, noise=float(found.x) * step, mismatch=float(found.fun))
        return replace(start, mismatch=quiet)

    def close(self) -> None:
        """Free the FMUs."""
        self._runs.close()


class LawSearch:
    """The search of a law's parameters; ``model`` is the best so far."""

    def __init__(self, cost: Mismatch) -> None:
        self._cost = cost
        self.model = cost.start
        self._algorithm = ga.optimiser("cma", ga.Problem(cost.genes), ga.Limits(), seed=0)

    def to(
        self,
        evaluations: int,
        executor: Executor | None,
        on_generation: Callable[[ga.Optimiser], object] | None,
    ) -> None:
        """Search until so many candidates were run, or the model is good."""
        self._algorithm.limits = ga.Limits(evaluations=evaluations, target=kept.ERRS_WELL)
        best = ga.learn(self._algorithm, self._cost, executor, on_generation).best
        self.model = replace(self._cost.model(best.values), mismatch=best.cost)


def errors_of(runs: LoopRuns, values: Mapping[str, float] | None = None) -> Array:
    """Return the errors that are shown, (loops of ``PROBES``, regions of the motion)."""
    shown = [runs.shown(runs.run(runs.bench.loop(genes), values)) for genes in PROBES]
    return np.array([list(runs.errors(v).values()) for v in shown])


def fit_models(
    bench: LoopBench,
    on_generation: Callable[[ga.Optimiser], object] | None = None,
    workers: int = 1,
) -> list[DriveModel]:
    """Run the drive in the loops of ``PROBES``, and find models that err alike, the best first.

    What was identified is enough where it errs like the drive. Otherwise each law whose start runs
    and is not hopeless has a short search, and the best go on. Raises ga.NothingLearned,
    ga.Interrupted as ``ga.learn``.
    """
    with closing(LoopRuns(bench)) as drive:
        errors = errors_of(drive)
    with ExitStack() as opened:
        opened.enter_context(threadpool_limits(limits=1, user_api="blas"))
        executor = opened.enter_context(ga.executor("threads", workers))

        def begun(law: str) -> LawSearch:
            return LawSearch(opened.enter_context(Mismatch(bench, law, errors)))

        own = bench.rig.law.name if bench.rig.law.name in LAWS else LAWS[0]
        found = [begun(own)]
        if found[0].model.mismatch > kept.ERRS_ALIKE:
            found += [begun(law) for law in LAWS if law != own]
            most = kept.HOPELESS * min(one.model.mismatch for one in found)
            found = [one for one in found if one.model.mismatch <= most]
            for evaluations in ROUNDS:
                for one in found:
                    if min(each.model.mismatch for each in found) > kept.ERRS_WELL:
                        one.to(evaluations, executor, on_generation)
                found = sorted(found, key=lambda one: one.model.mismatch)[:FINALISTS]
    least = found[0].model.mismatch
    return [one.model for one in found if one.model.mismatch <= kept.FURTHER * least]
