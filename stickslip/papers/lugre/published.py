"""The paper's learning as published, from coarse starts over seeds, beside least squares.

    study = study_as_published(rig, identification, seeds=range(10), workers=2)

As published: Table 3, Steps 1 to 4, (6) and (7), and no later step. The paper leaves open what its
"real number strings" are; with genes on a logarithmic scale the same algorithm lowers the cost.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pandas as pd

from stickslip import ga
from stickslip.catalog.parameters import LUGRE, UNITS
from stickslip.evaluation.comparison import Entry, Evaluation, evaluate
from stickslip.evaluation.motions import TRAINING
from stickslip.evaluation.validation import PHASES, summary
from stickslip.fmi.process import Threads
from stickslip.identification.stages import Identification
from stickslip.papers.lugre.loop_tuning import courses
from stickslip.papers.lugre.steps import UNCOMPENSATED
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.measurement import Array
from stickslip.tuning.learning import Study, VelocityCost, coarsened, draw_factors, genes
from stickslip.tuning.refinement import refine

PAPER_COST = 1.7e-3  # Where Fig. 5 of the paper ends [m^2/s^2, by our reading of its unit].
START, OURS, LOGARITHMIC, SQUARES = "start", "as_published", "logarithmic", "least_squares"
"""Names of methods: the coarse starts as they are, the paper's learning with genes that are linear
between their limits, the same with logarithmic ones, least squares."""
TABLES = ("panel", "fitness", "learned")
"""The names of the study's tables, as which they are written."""


@dataclass(frozen=True)
class SeedRun:
    """What one method made of one seed's coarse start."""

    seed: int
    parameters: Mapping[str, float]  # the five of them by name, SI units
    cost: float  # (6) of the training run with them [m^2/s^2]
    # of the drive that it took, as the paper counts them: those of the elite included
    runs: int = 0
    algorithm: ga.GeneticAlgorithm | None = None  # what searched, None where nothing did


@dataclass(frozen=True)
class PublishedStudy:
    """All seeds with all methods on one drive."""

    seeds: Mapping[str, Sequence[SeedRun]]  # by name of the method
    cost_without: float  # (6) of the training run without compensation [m^2/s^2]
    # all motions without compensation and with each method, over seeds and phases
    evaluation: Evaluation

    def costs(self, method: str) -> Array:
        """Return the cost of each seed, shape (seeds,), in m^2/s^2."""
        return np.array([one.cost for one in self.seeds[method]])

    def left(self, method: str) -> pd.DataFrame:
        """Return by motion what a method leaves of the error without compensation.

        The RMS error of the true velocity, as the geometric mean over the motion's regions. The
        columns are the phases of the first seed, then those of the next.
        """
        of_method, without = (
            pd.DataFrame(
                self.evaluation.errors[name].xs(("true", "E_rms"), level=("velocity", "metric"))
            )
            for name in (method, UNCOMPENSATED)
        )
        ratio = of_method / np.tile(without, len(self.seeds[method]))
        logs = pd.DataFrame(np.log(ratio), index=of_method.index)
        return pd.DataFrame(np.exp(logs.groupby("motion", sort=False).mean()))

    def panel(self) -> pd.DataFrame:
        """Tabulate the methods: seeds, runs, cost, and what is left in each motion, with ranges."""
        rows = []
        for method, seeds in self.seeds.items():
            found = {"cost": pd.DataFrame([self.costs(method)])}
            for motion, left in self.left(method).iterrows():
                found[str(motion).replace(" ", "_")] = pd.DataFrame([left.to_numpy()])
            runs = int(np.median([one.runs for one in seeds]))
            rows.append(
                {"method": method, "seeds": len(seeds), "runs": runs, **summary(found).iloc[0]}
            )
        return pd.DataFrame(rows)

    def fitness(self) -> pd.DataFrame:
        """Tabulate the learning: seed, generation, evaluations, runs, best_cost, mean_cost.

        ``runs`` counts as the paper does, the elite of each generation included; ``evaluations``
        leaves it out, because its cost is known.
        """
        table = courses((one.seed, one.algorithm) for one in self.seeds[OURS] if one.algorithm)
        table.insert(3, "runs", table["generation"] * ga.PAPER.population)
        return table

    def learned(self) -> pd.DataFrame:
        """Tabulate the five parameters and the cost: seed, quantity, unit, a column a method."""
        rows = []
        for runs in zip(*self.seeds.values(), strict=True):
            found = [{**one.parameters, "cost": one.cost} for one in runs]
            for name, unit in {**{n: UNITS[n] for n in LUGRE}, "cost": "m2/s2"}.items():
                rows.append((runs[0].seed, name, unit, *(one[name] for one in found)))
        return pd.DataFrame(rows, columns=["seed", "quantity", "unit", *self.seeds])

    def tables(self) -> dict[str, pd.DataFrame]:
        """Return all tables by the names of ``TABLES``."""
        return dict(zip(TABLES, (self.panel(), self.fitness(), self.learned()), strict=True))


def study_as_published(
    rig: FmuRig,
    identification: Identification,
    seeds: Sequence[int],
    *,
    workers: int = 1,
    settings: ga.Settings = ga.PAPER,  # of the algorithm as published
    on_stage: Callable[[str], object] = lambda _: None,
) -> PublishedStudy:
    """Learn from the coarse start of each seed, as published and by least squares, side by side."""
    loop = identification.loop
    settings_of = {OURS: settings, LOGARITHMIC: replace(settings, encoding="log")}
    methods = (START, OURS, LOGARITHMIC, SQUARES)
    v_cmd = TRAINING.sample(rig.samples(TRAINING.duration))
    studies = {
        seed: Study(rig, loop, coarsened(identification.estimates, draw_factors(seed)), v_cmd)
        for seed in seeds
    }
    on_stage(f"learning as published and by least squares, {len(seeds)} seeds")
    with rig.cost_of(v_cmd, loop, VelocityCost(rig.T_s)) as cost, Threads(workers) as threads:

        def learn(task: tuple[str, int]) -> SeedRun:
            method, seed = task
            start = studies[seed].start
            if method in settings_of:
                return _search(genes(start), settings_of[method], seed, cost)
            values, runs = {name: one.value for name, one in start.items()}, 0
            if method == SQUARES:
                fitted = refine(studies[seed])
                values, runs = dict(fitted.values), fitted.runs
            return SeedRun(seed, values, cost(np.array([*values.values()])), runs)

        found = threads.each(learn, [(method, seed) for method in methods for seed in seeds])
    count = len(seeds)
    named = {name: found[k * count : (k + 1) * count] for k, name in enumerate(methods)}
    on_stage("all motions, as published")
    entries = {UNCOMPENSATED: Entry(loop)}
    for name, runs in named.items():
        first, *others = (one.parameters for one in runs)
        entries[name] = Entry(loop, first, others)
    evaluation = evaluate(rig, entries, phases=PHASES, workers=workers)
    return PublishedStudy(named, studies[seeds[0]].cost_without(), evaluation)


def _search(
    searched: Sequence[ga.Gene], settings: ga.Settings, seed: int, cost: ga.SimulatedCost
) -> SeedRun:
    @cache  # the drive FMU repeats itself bit for bit
    def known(key: bytes) -> float:
        return float(cost(np.frombuffer(key)))

    def evaluate(values: Array) -> float:
        return known(values.tobytes())

    evaluate.fatal = cost.fatal  # type: ignore[attr-defined]
    algorithm = ga.GeneticAlgorithm(searched, settings, seed)
    ga.learn(algorithm, evaluate)
    best = algorithm.best
    names = [gene.name for gene in searched]
    values = dict(zip(names, best.values.tolist(), strict=True))  # noqa: PD011 - an array
    return SeedRun(seed, values, best.cost, settings.population * settings.generations, algorithm)
