"""Many runs of one system with other parameters: all of a grid, or those that a search tries."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from numbers import Integral
from pathlib import Path
from typing import Any, Unpack

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits
from tqdm import tqdm

from stickslip import cosim, ga, output
from stickslip.cosim.display import html_table
from stickslip.cosim.signals.signals import Input
from stickslip.cosim.signals.tables import Inputs
from stickslip.errors import UsageError, number
from stickslip.figures import Figure, Figures, figure
from stickslip.fmi.by_name import by_name
from stickslip.fmi.description.variables import FLOATS
from stickslip.fmi.messages import printable
from stickslip.ga.execution.evaluation import DIED, Evaluator
from stickslip.ga.problem.problem import Array
from stickslip.keywords import RunOptions, named
from stickslip.simulation import Model

_RANGE = "(lowest, highest) or (lowest, start, highest)"
_log = logging.getLogger(__name__)

NEAR = 0.01  # share of a range at its ends; a least cost there may be an end, not a minimum
Progress = Callable[[int, int], object]  # takes how many runs are done and how many there are


@dataclass(frozen=True)
class Optimum:
    """What a search found."""

    parameters: dict[str, float]  # the best values by name, in the unit of each variable
    cost: float  # of these
    # a row for each run, in order: generation, the parameters, cost, and the reason where a run
    # failed
    table: pd.DataFrame
    stopped: str  # why the search ended
    units: Mapping[str, str]  # of the parameters, by name
    ranges: Mapping[str, tuple[float, float]]  # in which they were searched

    def __repr__(self) -> str:
        values = ", ".join(f"{name} = {value:.6g}" for name, value in self.parameters.items())
        return f"Optimum({values}; cost {self.cost:.6g}, {self._runs})"

    def _repr_html_(self) -> str:
        rows = [(name, f"{value:.6g}") for name, value in self.parameters.items()]
        caption = f"cost {self.cost:.6g}, {self._runs}"
        return html_table(("parameter", "value"), rows, caption, words=1)

    @property
    def at_end(self) -> str:
        """Which parameters are near an end of their range, as the end of a sentence, or empty."""
        names = [name for name, span in self.ranges.items() if self._is_near_end(name, *span)]
        return f"; {', '.join(names)}: near an end of the range, try a wider one" if names else ""

    def _is_near_end(self, name: str, low: float, high: float) -> bool:
        value = self.parameters[name]
        if low > 0.0:  # searched by the logarithm
            value, low, high = map(math.log, (value, low, high))
        return min(value - low, high - value) < NEAR * (high - low)

    @property
    def _runs(self) -> str:
        return f"{len(self.table)} runs; {self.stopped}{self.at_end}"


@named(RunOptions)
def sweep(
    system: cosim.System | cosim.Fmu | Path | str,
    parameters: Mapping[str, Iterable[float | str]],
    figures: Mapping[str, Figure],
    *,
    inputs: Inputs | None = None,
    workers: int = 1,
    where: str = "threads",
    progress: Progress | bool = False,
    **options: Unpack[RunOptions],
) -> pd.DataFrame:
    """Run a system for every combination of parameter values.

    Runs go on side by side; the table does not depend on it. Each worker instantiates the FMUs
    once.

    Parameters
    ----------
    system : a system, an FMU, FILE.fmu or FILE.ssp
    parameters : ``component.variable``, or ``variable`` of one FMU, -> values in its unit
    figures : name -> a function of the result that gives a number
    inputs : signals by exposed input, as of ``simulate``; the same in every run
    workers, where : how many, and ``threads``, ``processes`` or the address of a Dask
        scheduler
    progress : whether to show a bar; or a function of how many runs are done and how many there are
    start, stop, step, record and all others : as of ``simulate``

    Returns
    -------
    pandas.DataFrame
        a row for each combination, the last parameter varying first: the parameters, then the
        figures. A run or figure that failed has NaN, and the reason in a further column
        ``reason``, which is absent where none failed.

    Raises
    ------
    UsageError
        When there is nothing to vary or to evaluate, a name comes twice, something drives what
        is to be varied, or no run gives a figure.
    CosimError
        When the system, a name or an input is wrong.
    """
    figures = by_name("figures", figures, UsageError)
    given = by_name("parameters", parameters, UsageError)
    values = {name: _values(name, some) for name, some in given.items()}
    if not values or not all(values.values()) or not figures:
        raise UsageError("a sweep needs parameters with values, and figures")
    if taken := sorted({*values, "reason"} & {*figures}):
        raise UsageError(f"figure {taken[0]!r}: has the name of another column; choose another")
    model, specification, signals = _prepared(system, inputs, options)
    names = [model.target(name) for name in values]
    model.require_free(names, signals)
    for name, some in zip(names, values.values(), strict=True):
        some[:] = [number(name, model.system.checked(name, value)) for value in some]
    grid = list(product(*values.values()))
    rows: list[Mapping[str, Any]] = []
    failed: list[str] = []
    with (
        ga.SimulatedCost(specification, names, Figures(figures), signals) as evaluate,
        threadpool_limits(limits=1, user_api="blas"),
        ga.executor(where, workers) as executor,
        _shown(progress) as report,
    ):
        for found in _evaluated(evaluate, np.array(grid), executor, workers):
            rows.append({**dict(zip(values, grid[len(rows)], strict=True)), **found})
            if "reason" in found and not failed:
                failed.append("reason")
                if len(rows) < len(grid):  # soon enough to stop the others
                    _log.warning("a run of the sweep failed: %s", found["reason"])
            report(len(rows), len(grid))
    first = rows[0].get("reason", "")
    if first.startswith(("figure ", DIED)) and not any({*figures} & {*row} for row in rows):
        raise UsageError(f"{first}; no run gave a figure")
    columns = [*values, *figures, *failed]
    table = pd.DataFrame(rows, columns=columns)
    return table.fillna({"reason": ""}) if failed else table


@named(RunOptions)
def optimise(
    system: cosim.System | cosim.Fmu | Path | str,
    ranges: Mapping[str, Sequence[float]],
    cost: Figure,
    *,
    inputs: Inputs | None = None,
    evaluations: int = 300,
    algorithm: str = "default",
    seed: int = 0,
    workers: int = 1,
    where: str = "threads",
    progress: output.Progress | Progress | bool = False,
    **options: Unpack[RunOptions],
) -> Optimum:
    """Search the parameters of a system for which a cost is least, by the genetic algorithm.

    Parameters
    ----------
    system, inputs, workers, where : as of ``sweep``
    progress : as of ``sweep``, or an ``ss.Progress``, which is told of generations
    ranges : name -> (lowest, start, highest), or (lowest, highest) to start with the value of the
        system, in the unit of the variable; searched by the logarithm where the lowest is above 0
    cost : of a result, 0 or more
    evaluations : budget of runs; the first generation, of about ten, is run whatever it is
    algorithm : ``default``, ``paper`` or ``cma``
    seed : random seed; the same seed gives the same search, whatever the workers
    start, stop, step, record and all others : as of ``simulate``

    Raises
    ------
    UsageError
        When a range has not two or three numbers, or the seed or the budget is not a number.
    GaError
        When a range or setting makes no sense, or every run of the first generation failed, or
        its cost.
    CosimError
        When the system, a name or an input is wrong.
    """
    model, specification, signals = _prepared(system, inputs, options)
    genes, units = list[ga.Gene](), dict[str, str]()
    if not (spans := by_name("ranges", ranges, UsageError)):
        raise UsageError("ranges: expected one variable or more, got none")
    for name, span in spans.items():
        three = [number(name, one) for one in _values(name, span)]
        if len(three) == 2:
            low, high = three
            three.insert(1, min(max(model.start(name), low), high))
        if len(three) != 3:
            raise UsageError(f"{name}: expected {_RANGE}, got {tuple(span)}")
        low, start, high = three
        if not low <= start <= high or low == high:
            raise UsageError(f"{name}: expected {_RANGE} that grow, got {tuple(span)}")
        target = model.target(name)
        if (kind := model.system.variable(target).type) not in FLOATS:
            raise UsageError(f"{name}: expected a real number to search, got one of type {kind}")
        for end in (low, high):
            model.system.checked(target, end)
        if not low <= (present := model.start(name)) <= high and len(span) == 2:
            _log.warning(
                "%s: its own value, %.6g, is outside the range; the search begins at %.6g",
                *(name, present, start),
            )
        units[name] = model.system.unit(target) or ""
        genes.append(ga.Gene(name, low, high, start, unit=units[name], linear=low <= 0.0))
    if not (isinstance(evaluations, Integral) and isinstance(seed, Integral) and seed >= 0):
        raise UsageError(
            f"evaluations = {evaluations!r} and seed = {seed!r}: expected whole numbers, the seed"
            " 0 or more"
        )
    limits = ga.Limits(evaluations=evaluations)
    search = ga.optimiser(algorithm, ga.Problem(genes), limits, seed)
    names = [model.target(name) for name in spans]
    model.require_free(names, signals)
    with (
        ga.SimulatedCost(
            specification, names, partial(figure, "the cost", cost), signals
        ) as evaluate,
        ga.executor(where, workers) as executor,
        _shown(not isinstance(progress, output.Progress) and progress) as report,
    ):

        def told(found: ga.Optimiser) -> None:
            report(found.evaluations, evaluations)
            if isinstance(progress, output.Progress):
                progress.generation(found)

        found = ga.learn(search, evaluate, executor, on_generation=told)
    table = search.history.drop(columns="index")
    ends = {gene.name: (gene.lower, gene.upper) for gene in genes}
    cost_of = float(found.best.cost)
    return Optimum(found.parameters, cost_of, table, found.stopped, units=units, ranges=ends)


_SHORT = 0.25  # s that a batch should take; a worker that dies takes down the runs of its share


def _evaluated(
    evaluate: ga.SimulatedCost, grid: Array, executor: Executor | None, workers: int
) -> Iterator[Mapping[str, Any]]:
    """Yield what is found for each row of a grid, in batches that grow while they take no time."""
    evaluator = Evaluator(evaluate, executor, workers)
    begin, size = 0, workers
    try:
        while begin < len(grid):
            size = max(size, getattr(executor, "parts", 0))  # of a cluster, which may grow
            started, end = time.monotonic(), begin + size
            ahead = grid[end : end + size]
            for found, reason in evaluator.outcomes(grid[begin:end], ahead, begins=False):
                yield {"reason": reason} if reason else found
            begin, size = end, size * (1 + (time.monotonic() - started < _SHORT))
    finally:
        evaluator.dismiss()


def _values(name: str, some: Iterable[float | str]) -> list[Any]:
    """Return the values of a parameter; text may name an item of an enumeration."""
    if isinstance(some, str) or not np.iterable(some):
        raise UsageError(f"{name}: expected its values in a list, got {printable(repr(some), 80)}")
    return [one if isinstance(one, str) else number(name, one) for one in some]


@contextmanager
def _shown(progress: Progress | bool) -> Iterator[Progress]:
    """Yield what takes the number of runs that are done and that there are."""
    if callable(progress):
        yield progress
        return
    with tqdm(disable=not progress, unit="run") as bar:

        def report(done: int, total: int) -> None:
            bar.total = total
            bar.update(done - bar.n)

        yield report


def _prepared(
    system: cosim.System | cosim.Fmu | Path | str, inputs: Inputs | None, options: RunOptions
) -> tuple[Model, cosim.Specification, Mapping[str, Input]]:
    """Return the model, what its runs have in common, and their inputs."""
    model = Model.of(system)
    with model.prepare(**options) as simulation:
        specification = replace(simulation.spec, system=model.system)
    return model, specification, model.signals(inputs)
