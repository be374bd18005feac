"""Learning as published from a coarse start for each of several seeds, side by side."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import CancelledError
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
import pandas as pd

from stickslip import ga
from stickslip.catalog.parameters import LUGRE, UNITS
from stickslip.evaluation.comparison import Entry, evaluate
from stickslip.evaluation.motions import SLOW_MOTIONS, windows
from stickslip.evaluation.validation import Run, Validation, run_command
from stickslip.fmi.process import Threads
from stickslip.ga.problem.problem import Repair
from stickslip.identification.stages import Estimate
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.measurement import CUTOFF, Array
from stickslip.servo.paper_commands import TRAINING, VALIDATION
from stickslip.servo.systems import Feed
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.tuning.coarse_start import coarsened, draw_factors
from stickslip.tuning.learning import VelocityCost, genes

Result = TypeVar("Result")
OnGeneration = Callable[[ga.Optimiser], object]

PAPER_COST = 1.7e-3
"""Where Fig. 5 of the paper ends [m^2/s^2, by our reading of its unit]."""


@dataclass(frozen=True)
class Method:
    """How a reading of the paper learns; the defaults are ours.

    Attributes
    ----------
    settings, repair : of the genetic algorithm
    width : of the coarse start, times ``coarse.SPREAD``
    cutoff : low-pass of v - v_r in the cost (6) [Hz], None for none
    delta : exponent of (4)
    feed : what drives the compensator
    """

    settings: ga.Settings = ga.PAPER
    repair: Repair | None = None
    width: float = 1.0
    cutoff: float | None = CUTOFF
    delta: float = 1.0
    feed: Feed = "nominal"


@dataclass(frozen=True)
class SeedRun:
    """One seed: its coarse start, what was learned from it, and the trapezoid with both.

    Attributes
    ----------
    start, learned : the five parameters by name, SI units
    simulated : runs of the drive that were not repetitions of one before
    with_start, with_learned : the trapezoid with each as the compensator
    """

    seed: int
    start: dict[str, float]
    learned: dict[str, float]
    algorithm: ga.GeneticAlgorithm
    simulated: int
    with_start: Run
    with_learned: Run


@dataclass(frozen=True)
class Published:
    """All seeds of one method on one drive.

    Attributes
    ----------
    without : the trapezoid without compensation
    cost_without : (6) of the training run without compensation [m^2/s^2]
    """

    method: Method
    seeds: tuple[SeedRun, ...]
    without: Run
    cost_without: float

    def fitness(self) -> pd.DataFrame:
        """Tabulate the learning: seed, generation, evaluations, runs, best_cost, mean_cost.

        ``runs`` counts as the paper does, the elite of each generation included; ``evaluations``
        leaves it out, because its cost is known.
        """
        tables = []
        for one in self.seeds:
            table = one.algorithm.convergence()
            table.insert(0, "seed", one.seed)
            table.insert(3, "runs", table["generation"] * self.method.settings.population)
            tables.append(table)
        return pd.concat(tables, ignore_index=True)

    @cached_property
    def _table4(self) -> pd.DataFrame:
        instants = windows(VALIDATION)
        tables = []
        for one in self.seeds:
            table = Validation(self.without, one.with_learned, instants).table()
            start = Validation(self.without, one.with_start, instants).table()["with"]
            table.insert(list(table.columns).index("with"), "start", start)
            table.insert(0, "seed", one.seed)
            tables.append(table)
        return pd.concat(tables, ignore_index=True)

    def table4(self) -> pd.DataFrame:
        """Return Table 4 for each seed: its columns, ``seed``, and ``start`` [mm/s]."""
        return self._table4.copy()

    def learned(self) -> pd.DataFrame:
        """Tabulate the parameters: seed, parameter, unit, start, learned."""
        rows = [
            (one.seed, name, UNITS[name], one.start[name], one.learned[name])
            for one in self.seeds
            for name in LUGRE
        ]
        return pd.DataFrame(rows, columns=["seed", "parameter", "unit", "start", "learned"])

    def final_costs(self) -> Array:
        """Return the best cost of each seed, shape (seeds,), in m^2/s^2."""
        return np.array([one.algorithm.best.cost for one in self.seeds])

    def start_costs(self) -> Array:
        """Return the cost of each seed's coarse start, shape (seeds,), in m^2/s^2."""
        return np.array([float(one.algorithm.history["cost"].iloc[0]) for one in self.seeds])


def learn_as_published(
    rig: FmuRig,
    loop: VelocityLoop,
    identified: Mapping[str, Estimate],
    seeds: Sequence[int],
    method: Method | None = None,
    workers: int = 1,
) -> Published:
    """Learn from the coarse start of each seed; the result does not depend on ``workers``.

    Parameters
    ----------
    identified : what the three experiments found, SI units
    workers : seeds side by side
    """
    method = method or Method()
    v_cmd = TRAINING.sample(rig.samples(TRAINING.duration))
    corners = VALIDATION.corners()
    trapezoid = VALIDATION.sample(rig.samples(corners[-1] + VALIDATION.begin))
    criterion = VelocityCost(rig.T_s, method.cutoff)
    own = {"delta": method.delta}

    def validated(values: Mapping[str, float]) -> Run:
        return run_command(rig, loop, {**values, **own}, trapezoid, method.feed)

    with rig.cost_of(v_cmd, loop, criterion, method.feed, own) as cost:

        def learn(seed: int, still_wanted: OnGeneration) -> SeedRun:
            start = coarsened(identified, draw_factors(seed, method.width))
            algorithm = ga.GeneticAlgorithm(genes(start), method.settings, seed, method.repair)
            once = _Once(cost)
            ga.learn(algorithm, once, on_generation=still_wanted)
            values = {name: one.value for name, one in start.items()}
            best = algorithm.best.values.tolist()  # noqa: PD011 - parameters by name
            learned = dict(zip(start, best, strict=True))
            runs = validated(values), validated(learned)
            return SeedRun(seed, values, learned, algorithm, len(once.costs), *runs)

        runs = tuple(side_by_side(learn, seeds, workers))
    with rig.cost_of(v_cmd, loop, criterion, compensated=False) as cost:
        cost_without = cost(np.array([identified[name].value for name in LUGRE]))
    without = run_command(rig, loop, None, trapezoid, method.feed)
    return Published(method, runs, without, cost_without)


def slow_motions(rig: FmuRig, loop: VelocityLoop, published: Published) -> pd.DataFrame:
    """Return RMS errors of the true velocity [mm/s] in slow motions, which the cost hardly shows.

    Columns seed, motion, region, ``without``, ``start`` and ``with``, as in ``Published.table4``.
    """
    own = {"delta": published.method.delta}
    entries = {"without": Entry(loop)}
    for one in published.seeds:
        entries[f"start {one.seed}"] = Entry(loop, {**one.start, **own})
        entries[f"with {one.seed}"] = Entry(loop, {**one.learned, **own})
    found = evaluate(rig, entries, published.method.feed, SLOW_MOTIONS).table()
    found = found[(found["metric"] == "E_rms") & (found["velocity"] == "true")]
    tables = []
    for one in published.seeds:
        table = found[["motion", "region", "without"]].copy()
        table.insert(0, "seed", one.seed)
        tables.append(table.assign(**{n: found[f"{n} {one.seed}"] for n in ("start", "with")}))
    return pd.concat(tables, ignore_index=True)


def worth(slow: pd.DataFrame) -> str:
    """Return what the learned compensators are worth in ``slow_motions``, as a sentence."""
    ratios = slow.assign(start=slow["with"] / slow["start"], without=slow["with"] / slow["without"])
    worst = ratios.groupby("seed")[["start", "without"]].max()
    return (
        f"in slow motions the learned compensators leave at worst {worst['start'].median():.3g} "
        f"times the error of their start in the median of seeds, up to {worst['start'].max():.3g}, "
        f"and in {int((worst['without'] > 1.0).sum())} of {len(worst)} seeds more than no "
        f"compensation, up to {worst['without'].max():.3g} times: the cost does not show F_s and "
        "v_s, and nothing else decides what is kept"
    )


def side_by_side(
    learn: Callable[[int, OnGeneration], Result], seeds: Sequence[int], workers: int
) -> list[Result]:
    """Learn with each seed; when one fails or Ctrl-C comes, the others end with their generation.

    Parameters
    ----------
    learn : takes a seed, and what it must call after each generation
    """
    cancelled = threading.Event()

    def still_wanted(_: ga.Optimiser) -> None:
        if cancelled.is_set():
            raise CancelledError

    with Threads(workers) as threads:
        try:
            return threads.each(lambda seed: learn(seed, still_wanted), seeds)
        except BaseException:
            cancelled.set()
            raise


class _Once:
    """A cost that runs each candidate once: the drive FMU repeats itself bit for bit."""

    def __init__(self, cost: Callable[[Array], float]) -> None:
        self._cost = cost
        self.fatal = getattr(cost, "fatal", ())
        self.costs: dict[bytes, float] = {}

    def __call__(self, values: Array) -> float:
        key = values.tobytes()
        if key not in self.costs:
            self.costs[key] = self._cost(values)
        return self.costs[key]
