"""The paper's learning as published, from coarse starts over seeds, beside least squares.

    study = study_as_published(rig, identification, seeds=range(10), workers=2)

As published: Table 3, Steps 1 to 4, (6) and (7), and no later step. Half of the seeds also learn
under each other reading of the paper that changes the result by more than seeds differ.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import CancelledError
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import pandas as pd

from stickslip import ga
from stickslip.catalog.parameters import LUGRE, UNITS
from stickslip.evaluation.comparison import Entry, Evaluation, evaluate
from stickslip.evaluation.motions import MOTIONS
from stickslip.evaluation.scatter import PHASES, summary
from stickslip.fmi.process import Threads
from stickslip.identification.stages import Estimate, Identification
from stickslip.papers.lugre.motion_study import UNCOMPENSATED
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.measurement import Array
from stickslip.servo.paper_commands import TRAINING
from stickslip.servo.systems import Feed
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.tuning.coarse_start import coarsened, draw_factors
from stickslip.tuning.learning import Study, VelocityCost, genes
from stickslip.tuning.refinement import refine

Result = TypeVar("Result")
Item = TypeVar("Item")
OnGeneration = Callable[[ga.Optimiser], object]

PAPER_COST = 1.7e-3
"""Where Fig. 5 of the paper ends [m^2/s^2, by our reading of its unit]."""
START, OURS, SQUARES = "start", "as_published", "least_squares"
"""Names of methods: the coarse starts as they are, our reading of the paper, least squares."""
TABLES = ("panel", "fitness", "learned", "motions")
"""The names of the study's tables, as which they are written."""


@dataclass(frozen=True)
class Reading:
    """A place of the paper that can be read in more than one way.

    Attributes
    ----------
    place : where in the paper
    ours, other : both readings, in words
    settings : of the other one
    """

    place: str
    ours: str
    other: str
    settings: ga.Settings


READINGS = {
    "logarithmic": Reading(
        "Step 2, “real number strings”",
        "linear between the limits",
        "logarithmic between the limits",
        replace(ga.PAPER, encoding="log"),
    ),
}
"""Readings that change the result, by the names of their methods."""


@dataclass(frozen=True)
class SeedRun:
    """What one method made of one seed's coarse start.

    Attributes
    ----------
    parameters : the five of them by name, SI units
    cost : (6) of the training run with them [m^2/s^2]
    runs : of the drive that it took, as the paper counts them: those of the elite included
    algorithm : what searched, None where nothing did
    """

    seed: int
    parameters: Mapping[str, float]
    cost: float
    runs: int = 0
    algorithm: ga.GeneticAlgorithm | None = None


@dataclass(frozen=True)
class PublishedStudy:
    """All seeds with all methods on one drive.

    Attributes
    ----------
    seeds : by name of the method
    cost_without : (6) of the training run without compensation [m^2/s^2]
    evaluation : all motions without compensation and with each method, over seeds and phases
    """

    seeds: Mapping[str, Sequence[SeedRun]]
    cost_without: float
    evaluation: Evaluation

    def costs(self, method: str) -> Array:
        """Return the cost of each seed, shape (seeds,), in m^2/s^2."""
        return np.array([one.cost for one in self.seeds[method]])

    def left(self, method: str) -> pd.DataFrame:
        """Return by motion what a method leaves of the error without compensation.

        The RMS error of the true velocity, as the geometric mean over the motion's regions. The
        columns are the phases of the first seed, then those of the next.
        """
        with_it, without = (self._rms(name) for name in (method, UNCOMPENSATED))
        ratio = with_it / np.tile(without, len(self.seeds[method]))
        logs = pd.DataFrame(np.log(ratio), index=with_it.index)
        return pd.DataFrame(np.exp(logs.groupby("motion", sort=False).mean()))

    def _rms(self, name: str) -> pd.DataFrame:
        rows = self.evaluation.errors[name].xs(("true", "E_rms"), level=("velocity", "metric"))
        return pd.DataFrame(rows)

    def left_by_seed(self, method: str) -> Array:
        """Return ``left`` with the shape (motions, seeds, phases)."""
        left = self.left(method).to_numpy()
        return left.reshape(len(left), len(self.seeds[method]), -1)

    def worse(self, method: str) -> tuple[int, int]:
        """Return how many seeds leave more than their start on the trapezoid, and in slow motion.

        More is a median over the phases above the largest error of the start.
        """
        left = self.left_by_seed(method)
        start = self.left_by_seed(START)[:, : left.shape[1]]
        worse = np.median(left, axis=2) > start.max(axis=2)
        return int(worse[0].sum()), int(worse[1:].any(axis=0).sum())

    def panel(self) -> pd.DataFrame:
        """Tabulate the methods: seeds, runs (median), cost, then what is left in each motion.

        Medians with ranges: of the cost [m^2/s^2] over seeds, of the rest over seeds and phases.
        ``worse`` counts the seeds that follow the trapezoid worse than from their start,
        ``worse_slow`` those that do so in a slow motion.
        """
        rows = []
        for method, seeds in self.seeds.items():
            found = {"cost": pd.DataFrame([self.costs(method)])}
            for motion, left in self.left(method).iterrows():
                found[str(motion).replace(" ", "_")] = pd.DataFrame([left.to_numpy()])
            runs = int(np.median([one.runs for one in seeds]))
            row = {"method": method, "seeds": len(seeds), "runs": runs, **summary(found).iloc[0]}
            row["worse"], row["worse_slow"] = self.worse(method)
            rows.append(row)
        return pd.DataFrame(rows)

    def fitness(self) -> pd.DataFrame:
        """Tabulate the learning: seed, generation, evaluations, runs, best_cost, mean_cost.

        ``runs`` counts as the paper does, the elite of each generation included; ``evaluations``
        leaves it out, because its cost is known.
        """
        tables = []
        for one in self.seeds[OURS]:
            assert one.algorithm is not None  # noqa: S101 - our reading searches
            table = one.algorithm.convergence()
            table.insert(0, "seed", one.seed)
            table.insert(3, "runs", table["generation"] * ga.PAPER.population)
            tables.append(table)
        return pd.concat(tables, ignore_index=True)

    def learned(self) -> pd.DataFrame:
        """Tabulate what each seed found: seed, quantity, unit, start, as_published, least_squares.

        The quantities are the parameters and the cost.
        """
        methods = (START, OURS, SQUARES)
        rows = []
        for runs in zip(*(self.seeds[method] for method in methods), strict=True):
            found = [{**one.parameters, "cost": one.cost} for one in runs]
            for name, unit in {**{n: UNITS[n] for n in LUGRE}, "cost": "m2/s2"}.items():
                rows.append((runs[0].seed, name, unit, *(one[name] for one in found)))
        return pd.DataFrame(rows, columns=["seed", "quantity", "unit", *methods])

    def tables(self) -> dict[str, pd.DataFrame]:
        """Return all tables by the names of ``TABLES``."""
        found = (self.panel(), self.fitness(), self.learned(), self.evaluation.table())
        return dict(zip(TABLES, found, strict=True))


def study_as_published(
    rig: FmuRig,
    identification: Identification,
    seeds: Sequence[int],
    *,
    feed: Feed = "nominal",
    workers: int = 1,
    settings: ga.Settings = ga.PAPER,
    readings: Mapping[str, Reading] = READINGS,
    on_stage: Callable[[str], object] = lambda _: None,
) -> PublishedStudy:
    """Learn from the coarse start of each seed, as published and by least squares.

    The result does not depend on ``workers``, which learn side by side.

    Parameters
    ----------
    feed : what drives the compensator
    settings : of our reading
    readings : other ones, under which the first half of the seeds learn
    """
    loop = identification.loop
    settings_of = {OURS: settings, **{name: one.settings for name, one in readings.items()}}
    some = seeds[: len(seeds) // 2]
    tasks = [(OURS, seed) for seed in seeds] + [(SQUARES, seed) for seed in seeds]
    tasks += [(name, seed) for name in readings for seed in some]
    starts = {seed: coarsened(identification.estimates, draw_factors(seed)) for seed in seeds}
    v_cmd = TRAINING.sample(rig.samples(TRAINING.duration))
    studies = {seed: Study(rig, loop, start, v_cmd, feed) for seed, start in starts.items()}
    on_stage(f"learning as published, {len(seeds)} seeds; {len(readings)} other readings")
    with rig.cost_of(v_cmd, loop, VelocityCost(rig.T_s), feed) as cost:

        def learn(task: tuple[str, int], still_wanted: OnGeneration) -> SeedRun:
            method, seed = task
            if method == SQUARES:
                fitted = refine(studies[seed])
                values = fitted.values  # noqa: PD011 - parameters by name
                return SeedRun(seed, values, cost(np.array([*values.values()])), fitted.runs)
            chosen = settings_of[method]
            return _search(starts[seed], chosen, seed, cost, still_wanted)

        found = side_by_side(learn, tasks, workers)
        begun = [_start(seed, start, cost) for seed, start in starts.items()]
    named = {START: begun}
    for name in (OURS, SQUARES, *(readings if some else ())):
        named[name] = [one for (method, _), one in zip(tasks, found, strict=True) if method == name]
    on_stage("all motions, as published")
    evaluation = evaluate(rig, _entries(loop, named), feed, MOTIONS, PHASES, workers)
    return PublishedStudy(named, studies[seeds[0]].cost_without(), evaluation)


def _start(seed: int, start: Mapping[str, Estimate], cost: Callable[[Array], float]) -> SeedRun:
    values = {name: one.value for name, one in start.items()}
    return SeedRun(seed, values, cost(np.array([*values.values()])))


def _search(
    start: Mapping[str, Estimate],
    settings: ga.Settings,
    seed: int,
    cost: Callable[[Array], float],
    still_wanted: OnGeneration,
) -> SeedRun:
    algorithm = ga.GeneticAlgorithm(genes(start), settings, seed)
    ga.learn(algorithm, _Once(cost), on_generation=still_wanted)
    values = dict(zip(start, algorithm.best.values.tolist(), strict=True))  # noqa: PD011
    runs = settings.population * settings.generations
    return SeedRun(seed, values, algorithm.best.cost, runs, algorithm)


def _entries(loop: VelocityLoop, seeds: Mapping[str, Sequence[SeedRun]]) -> dict[str, Entry]:
    entries = {UNCOMPENSATED: Entry(loop)}
    for method, runs in seeds.items():
        first, *others = (one.parameters for one in runs)
        entries[method] = Entry(loop, first, others)
    return entries


def side_by_side(
    learn: Callable[[Item, OnGeneration], Result], items: Sequence[Item], workers: int
) -> list[Result]:
    """Learn with each item; when one fails or Ctrl-C comes, the others end with their generation.

    Parameters
    ----------
    learn : takes an item, and what it must call after each generation
    """
    cancelled = threading.Event()

    def still_wanted(_: ga.Optimiser) -> None:
        if cancelled.is_set():
            raise CancelledError

    with Threads(workers) as threads:
        try:
            return threads.each(lambda item: learn(item, still_wanted), items)
        except BaseException:
            cancelled.set()
            raise


class _Once:
    """A cost that runs each candidate once: the drive FMU repeats itself bit for bit."""

    def __init__(self, cost: Callable[[Array], float]) -> None:
        self._cost = cost
        self.fatal = getattr(cost, "fatal", ())
        self._costs: dict[bytes, float] = {}

    def __call__(self, values: Array) -> float:
        key = values.tobytes()
        if key not in self._costs:
            self._costs[key] = self._cost(values)
        return self._costs[key]
