"""Standard functions, each racer with the same evaluations, bounds and start: medians."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from cma import ff
from scipy.stats import mannwhitneyu

from benchmarks.learning.racers import Racer, cma, ours, pymoo_ga, race_one, scipy_de
from stickslip import ga

SCHWEFEL = 420.9687462275036
STYBLINSKI = -2.9035340277711772
LEVEL = 10.0
"""Mean of the noise, in its standard deviations: costs may not be negative."""


def ackley(z: np.ndarray) -> float:
    wide = 20 * np.exp(-0.2 * np.sqrt(np.mean(z**2)))
    return float(20 + np.e - wide - np.exp(np.mean(np.cos(2 * np.pi * z))))


def griewank(z: np.ndarray) -> float:
    waves = np.prod(np.cos(z / np.sqrt(np.arange(1, len(z) + 1))))
    return float(1 + z @ z / 4000 - waves)


def schwefel(z: np.ndarray) -> float:
    x = z + SCHWEFEL
    return float(np.sum(418.9828872724338 - x * np.sin(np.sqrt(np.abs(x)))))


def levy(z: np.ndarray) -> float:
    w = 1 + z / 4
    middle = (w[:-1] - 1) ** 2 * (1 + 10 * np.sin(np.pi * w[:-1] + 1) ** 2)
    ends = np.sin(np.pi * w[0]) ** 2 + (w[-1] - 1) ** 2 * (1 + np.sin(2 * np.pi * w[-1]) ** 2)
    return float(ends + np.sum(middle))


def zakharov(z: np.ndarray) -> float:
    tilt = 0.5 * float(np.arange(1, len(z) + 1) @ z)
    return float(z @ z + tilt**2 + tilt**4)


def dixon_price(z: np.ndarray) -> float:
    return float(ff.dixonprice(z + 2.0 ** (2.0 ** -np.arange(float(len(z))) - 1)))


def salomon(z: np.ndarray) -> float:
    r = float(np.linalg.norm(z))
    return 1 - np.cos(2 * np.pi * r) + 0.1 * r


def schaffer(z: np.ndarray) -> float:
    s = np.hypot(z[:-1], z[1:])
    return float(np.mean(np.sqrt(s) * (1 + np.sin(50 * s**0.2) ** 2)) ** 2)


@dataclass(frozen=True)
class Function:
    """A function of z (k,) that is 0 at the origin, and where that lies in a box."""

    value: Callable[[np.ndarray], float]
    lower: float  # end of the box of x, the same for each gene
    upper: float
    rotated: bool = False  # z is x less its lowest point, rotated
    noise: float = 0.0  # standard deviation of what each evaluation adds
    decades: bool = False  # x is searched by its logarithm
    lowest: float | None = None  # of each gene, where it has a place of its own, mirrored at random


class Instance:
    """A function in k dimensions whose lowest point, start, rotation and noise follow a seed."""

    def __init__(self, function: Function, k: int, seed: int) -> None:
        rng = np.random.default_rng([seed, k])
        self._function = function
        span = function.upper - function.lower
        start = function.lower + span * rng.random(k)
        self._lowest = function.lower + span * rng.uniform(0.2, 0.8, k)
        self._turn = np.eye(k)
        if function.rotated:
            self._turn = np.linalg.qr(rng.standard_normal((k, k)))[0]
        if function.lowest is not None:
            self._turn = np.diag(rng.choice([-1.0, 1.0], k))
            self._lowest = self._turn @ np.full(k, function.lowest)
        self._noise = np.random.default_rng([seed, k, 1])
        ends = [self._x(np.array(end)) for end in (function.lower, function.upper)]
        self.problem = ga.Problem(
            [
                ga.Gene(f"x{i}", *map(float, ends), float(at), linear=not function.decades)
                for i, at in enumerate(self._x(start))
            ]
        )

    def _x(self, plain: np.ndarray) -> np.ndarray:
        return 10.0**plain if self._function.decades else plain

    def true(self, x: np.ndarray) -> float:
        """Return the function of x, shape (k,), without noise; 0 or above."""
        plain = np.log10(x) if self._function.decades else x
        return max(0.0, float(self._function.value(self._turn.T @ (plain - self._lowest))))

    def __call__(self, x: np.ndarray) -> float:
        """Evaluate x, shape (k,), with noise around a level that no cost falls below."""
        noise = self._function.noise
        return max(0.0, self.true(x) + noise * (LEVEL + self._noise.standard_normal()))


STANDARD = {
    "sphere": Function(ff.sphere, -5, 5),
    "ellipsoid": Function(ff.elli, -5, 5),
    "ellipsoid, rotated": Function(ff.elli, -5, 5, rotated=True),
    "Rosenbrock": Function(lambda z: ff.rosen(z + 1), -5, 10),
    "Zakharov": Function(zakharov, -5, 10),
    "Ackley": Function(ackley, -32.768, 32.768),
    "Griewank": Function(griewank, -600, 600),
    "Levy": Function(levy, -10, 10),
    "Rastrigin": Function(ff.rastrigin, -5.12, 5.12),
    "Rastrigin, rotated": Function(ff.rastrigin, -5.12, 5.12, rotated=True),
    "Schwefel": Function(schwefel, -500, 500, lowest=SCHWEFEL),
    "Styblinski-Tang": Function(
        lambda z: ff.styblinski_tang(z + STYBLINSKI), -5, 5, lowest=STYBLINSKI
    ),
    "sphere, noise": Function(ff.sphere, -5, 5, noise=1.0),
    "sphere, decades": Function(ff.sphere, -4, 4, decades=True),
    "ellipsoid, decades": Function(ff.elli, -4, 4, decades=True),
}
"""What is raced on."""
FURTHER = {
    "Rosenbrock, rotated": Function(lambda z: ff.rosen(z + 1), -5, 10, rotated=True),
    "Ackley, rotated": Function(ackley, -32.768, 32.768, rotated=True),
    "Levy, rotated": Function(levy, -10, 10, rotated=True),
    "cigar, rotated": Function(ff.cigar, -5, 5, rotated=True),
    "powers": Function(lambda z: np.sum(abs(z) ** np.linspace(2, 6, len(z))), -5, 5, rotated=True),
    "Dixon-Price": Function(dixon_price, -10, 10),
    "Alpine": Function(lambda z: np.sum(abs(z * np.sin(z) + 0.1 * z)), -10, 10),
    "Salomon": Function(salomon, -100, 100),
    "Schaffer": Function(schaffer, -100, 100),
    "steps": Function(lambda z: np.sum(np.floor(abs(z) + 0.5) ** 2), -100, 100),
    "Rosenbrock, noise": Function(lambda z: ff.rosen(z + 1), -5, 10, noise=10.0),
    "Rosenbrock, decades": Function(lambda z: ff.rosen(z + 1), -4, 4, decades=True),
}
"""Further ones."""
OURS = "ours"
CONTESTANTS: dict[str, Racer] = {
    OURS: ours("default"),
    "cma, 0.1": cma(0.1),
    "cma, 0.3": cma(0.3),
    "DE, 15": scipy_de(15),
    "DE, 2": scipy_de(2),
    "GA, 100": pymoo_ga(100),
    "GA, 20": pymoo_ga(20),
}
"""Populations of DE are given for each gene, as scipy counts them; of cma, the first sigma."""
REACHED = 1e-8
"""What costs less has arrived: it does not lose to another that has."""
DIMENSIONS = (5, 10)
SEVERAL = (2, 5, 10, 20, 30, 50, 100)


def run(out: Path, seeds: int, budget: int, genes: Sequence[int], *, further: bool) -> str:
    """Race on all functions; write functions.csv, return a table of medians and one of seconds.

    The further functions have other seeds than the standard ones, on which the default was chosen.
    Where the median of ours is above the lowest of the others, the last column has the
    probability (Mann and Whitney) that costs so much higher are chance.
    """
    functions, first = (FURTHER, seeds) if further else (STANDARD, 0)
    numbers = range(first, first + seeds)
    each = [_costs(name, functions[name], k, numbers, budget) for name in functions for k in genes]
    costs = pd.concat(each, ignore_index=True)
    costs.to_csv(out / "functions.csv", index=False)
    table = costs.pivot_table(
        "cost", ["function", "genes"], "racer", aggfunc="median", sort=False
    ).reindex(columns=list(CONTESTANTS))
    table["lost, p"] = [
        _chance(costs[(costs.function == name) & (costs.genes == k)]) for name, k in table.index
    ]
    return (
        f"lowest cost after {budget} evaluations, median of {seeds} seeds\n"
        f"{table.to_string(float_format='%.2g', na_rep='')}\n\n"
        f"seconds of one processor that {budget} evaluations of ours take, the cost's included\n"
        f"{_seconds(budget).to_string(float_format='%.2f')}"
    )


def _costs(name: str, function: Function, k: int, seeds: range, budget: int) -> pd.DataFrame:
    """Return what the best of every racer costs without noise, a row for each seed."""
    rows = []
    for racer, search in CONTESTANTS.items():
        for seed in seeds:
            instance = Instance(function, k, seed)
            found = race_one(search, instance, instance.problem, seed, budget).found
            rows.append((name, k, racer, seed, np.inf if found is None else instance.true(found)))
    return pd.DataFrame(rows, columns=["function", "genes", "racer", "seed", "cost"])


def _chance(costs: pd.DataFrame) -> float | None:
    """Return the probability that ours lost by chance, or None if its median is not higher."""
    medians = costs.groupby("racer").cost.median()
    best = str(medians.drop(OURS).idxmin())
    if medians[OURS] <= max(medians[best], REACHED):
        return None
    mine, theirs = (costs.cost[costs.racer == racer].clip(REACHED) for racer in (OURS, best))
    return float(mannwhitneyu(mine, theirs, alternative="greater").pvalue)


def _seconds(budget: int) -> pd.DataFrame:
    table = pd.DataFrame(index=pd.Index(SEVERAL, name="genes"))
    for name in ("sphere", "Rastrigin"):
        for k in SEVERAL:
            instance = Instance(STANDARD[name], k, 0)
            begin = time.process_time()
            optimiser = ga.optimiser("default", instance.problem, ga.Limits(evaluations=budget))
            ga.learn(optimiser, instance)
            table.loc[k, name] = time.process_time() - begin
    return table
