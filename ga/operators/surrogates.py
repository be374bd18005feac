"""Children where models of the cost are lowest, besides those of crossover and mutation.

A quadratic finds the minimum of one valley in a few steps. A round bowl has so few coefficients
that it averages out small valleys and finds the large one. Sections search gene by gene.
"""

from threading import Lock

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController

from stickslip.ga.operators.breeding import Shares
from stickslip.ga.problem.problem import Array

RADIUS = 2.0  # how far a step may go, in standard deviations of the points fitted to
LIGHTEST = 0.05  # weight of the most expensive point, relative to the cheapest
POINTS = 2  # a quadratic is fitted to so many times as many candidates as it has coefficients
LARGEST = 256
"""Coefficients of the largest quadratic; beyond, products of two variables are left out."""

SAME = 0.03
"""Candidates closer than this in each gene, on [0, 1], crowd each other in the fit of a bowl."""

THINNED = 400  # candidates that a bowl is fitted to at most


def unknowns(k: int) -> int:
    """Return the number of coefficients of a quadratic in k variables."""
    full = (k + 1) * (k + 2) // 2
    return full if full <= LARGEST else 2 * k + 1


def bottom(strings: Array, costs: Array) -> Array | None:
    """Return where a quadratic through candidates (n, k), the cheapest first, is lowest, (k,).

    It is within `RADIUS` of the cheapest, and may leave [0, 1]. None while there are too few
    candidates, or all cost the same.
    """
    k = strings.shape[1]
    strings, costs = strings[: POINTS * unknowns(k)], costs[: POINTS * unknowns(k)]
    finite = np.isfinite(costs)
    strings, costs = strings[finite], costs[finite]
    if len(strings) <= unknowns(k) or costs[0] == costs[-1]:
        return None
    variance, axes = np.linalg.eigh(np.cov(strings, rowvar=False).reshape(k, k))
    if variance[-1] <= 0:
        return None
    scale = np.sqrt(np.maximum(variance, 1e-16 * variance[-1]))
    away = (strings - strings[0]) @ axes / scale  # in standard deviations along principal axes
    gradient, curvature = _fit_quadratic(away, (costs - costs[0]) / (costs[-1] - costs[0]))
    return np.asarray(strings[0] + axes @ (scale * _step(gradient, curvature)))


def _fit_quadratic(points: Array, costs: Array) -> tuple[Array, Array]:
    """Fit gradient (k,) and Hessian (k, k) at the origin to points (n, k) and costs (n,)."""
    k = points.shape[1]
    rows, columns = np.triu_indices(k)
    if len(rows) > unknowns(k):
        rows, columns = np.diag_indices(k)
    terms = np.hstack([np.ones((len(points), 1)), points, points[:, rows] * points[:, columns]])
    weights = np.linspace(1.0, LIGHTEST, len(points))
    fitted = np.linalg.lstsq(terms * weights[:, np.newaxis], costs * weights, rcond=None)[0]
    half = np.zeros((k, k))
    half[rows, columns] = fitted[k + 1 :]
    return np.asarray(fitted[1 : k + 1], dtype=float), half + half.T


def _step(gradient: Array, hessian: Array) -> Array:
    """Return the lowest point (k,) of the quadratic within `RADIUS`.

    Source: Nocedal and Wright, Numerical Optimization, 2nd ed., section 4.3.
    """
    curvature, axes = np.linalg.eigh(hessian)
    slope = axes.T @ gradient
    size = float(np.abs(curvature).max()) or 1.0

    def step(shift: float) -> Array:
        return np.asarray(-slope / (curvature + shift))

    low = max(0.0, -float(curvature[0])) + 1e-9 * size
    if np.linalg.norm(step(low)) > RADIUS:
        high = low + float(np.linalg.norm(slope)) / RADIUS + size
        for _ in range(60):
            middle = (low + high) / 2
            if np.linalg.norm(step(middle)) > RADIUS:
                low = middle
            else:
                high = middle
        low = high
    return np.asarray(axes @ step(low))


def bowl(strings: Array, costs: Array) -> Array | None:
    """Return where a round bowl through candidates (n, k) in order of cost is lowest, (k,).

    Where candidates crowd, each counts less, so that the place does not depend on where most of
    them happen to be. None while there are too few candidates, or no bowl.
    """
    finite = np.isfinite(costs)
    thinned = slice(None, None, -(-int(finite.sum()) // THINNED) or 1)
    strings, costs = strings[finite][thinned], costs[finite][thinned]
    n, k = strings.shape
    if n < k + 3 or costs[0] == costs[-1]:
        return None
    middle = strings.mean(axis=0)
    away = strings - middle
    squares = np.sum(away**2, axis=1)
    apart = np.maximum(squares[:, np.newaxis] + squares - 2 * away @ away.T, 0.0)
    weights = 1 / np.sqrt(np.exp(-apart / (k * SAME**2)).sum(axis=1))
    terms = np.hstack([np.ones((n, 1)), away, squares[:, np.newaxis]])
    heights = (costs - costs[0]) / (costs[-1] - costs[0])
    fitted = np.linalg.lstsq(terms * weights[:, np.newaxis], heights * weights, rcond=None)[0]
    if not fitted[-1] > 0:
        return None
    return np.asarray(np.clip(middle - fitted[1:-1] / (2 * fitted[-1]), 0.0, 1.0))


FINEST = 1e-9  # a gene is not evaluated closer than this to a value that it had, on [0, 1]
FITTED = 0.5  # probability that a proposal is the minimum of a parabola, not the easiest interval
DEMANDS = 3  # decades below the range of the costs over which a wished improvement is drawn
_Section = tuple[Array, Array]
"""values of a gene in ascending order, and costs relative to those of the other sections"""


class Sections:
    """Sections along each of k axes through the best candidate (k,), with costs that add up."""

    def __init__(self, string: Array, cost: float) -> None:
        self._sections: list[_Section] = [(np.array([x]), np.zeros(1)) for x in string]
        self._string, self._cost = string.copy(), cost
        self._turn = 0  # whose gene is next

    def add(self, string: Array, cost: float) -> None:
        """Take a candidate, shape (k,), and its cost, 0 .. inf.

        What the sections do not explain of its cost is put down to the genes whose values are new,
        or to all that differ from the best candidate.
        """
        if not np.isfinite(cost):
            highest = max(float(np.ptp(costs)) for _, costs in self._sections)
            cost = self._cost + 10 * (highest or self._cost or 1.0)
        changed = np.flatnonzero(string != self._string).tolist()
        new = [j for j in changed if not (self._sections[j][0] == string[j]).any()]
        rise = sum(self._at(j, string[j]) - self._at(j, self._string[j]) for j in changed)
        for j in new or changed:
            share = (cost - self._cost - rise) / len(new or changed)
            self._put(j, string[j], self._at(j, string[j]) + share)

    def move(self, string: Array, cost: float) -> None:
        """Go through another candidate, shape (k,), of a finite cost."""
        self.add(string, cost)
        self._string, self._cost = string.copy(), cost

    def propose(self, count: int, rng: np.random.Generator) -> Array:
        """Return candidates, shape (count, k): the best one with one gene changed in each.

        The genes take turns. The first candidate has the best value of every section instead, if
        the best one does not have all but one of them.
        """
        children = np.tile(self._string, (count, 1))
        joined = np.array([values[np.argmin(costs)] for values, costs in self._sections])
        first = int(np.count_nonzero(joined != self._string) > 1)
        children[:first] = joined
        for child in children[first:]:
            j = self._turn % len(child)
            self._turn += 1
            values, costs = self._sections[j]
            fitted = _fitted(values, costs, rng) if rng.random() < FITTED else None
            child[j] = _easiest(values, costs, rng) if fitted is None else fitted
        return children

    def _at(self, j: int, value: float) -> float:
        return float(np.interp(value, *self._sections[j]))

    def _put(self, j: int, value: float, cost: float) -> None:
        values, costs = self._sections[j]
        place = int(np.searchsorted(values, value))
        if place < len(values) and values[place] == value:
            costs[place] = cost
        else:
            self._sections[j] = np.insert(values, place, value), np.insert(costs, place, cost)


def _fitted(values: Array, costs: Array, rng: np.random.Generator) -> float | None:
    """Return where a parabola through some values around the best is lowest, if that is new.

    Three of them find the minimum next to the best one; many see past the small ones.
    """
    if len(values) < 3:
        return None
    best = float(values[np.argmin(costs)])
    count = round(3 * (len(values) / 3) ** rng.random())
    near = np.argsort(np.abs(values - best), kind="stable")[:count]
    x, y = values[near], costs[near]
    low, span, height = float(x.min()), float(np.ptp(x)), float(np.ptp(y))
    if not height > 0:
        return None
    t = (x - low) / span
    terms = np.stack([np.ones(len(t)), t, t * t], axis=1)
    _, slope, bend = np.linalg.lstsq(terms, (y - y.min()) / height, rcond=None)[0]
    if not bend > 0:
        return None
    lowest = low + span * float(np.clip(-slope / (2 * bend), 0.0, 1.0))
    return None if np.abs(values - lowest).min() <= FINEST else lowest


def _easiest(values: Array, costs: Array, rng: np.random.Generator) -> float:
    """Return where the flattest parabola through two neighbours has a wished improvement.

    Beyond the outermost values the cost is taken to go on level. Small improvements are easiest
    next to the best value, large ones in wide gaps. Source: Langerman, Seront and Bersini, STEP:
    The Easiest Way to Optimize a Function, IEEE Conference on Evolutionary Computation (1994) 519.
    """
    ends = np.concatenate([[0.0], values, [1.0]])
    height = np.concatenate([costs[:1], costs, costs[-1:]]) - costs.min()
    share = 10.0 ** rng.uniform(-DEMANDS, 0)
    wish = max((float(height.max()) or 1.0) * share, np.finfo(float).tiny)  # never rounded to 0
    roots = np.sqrt(height + wish)
    width, rise = np.diff(ends), roots[:-1] + roots[1:]
    easiest = int(np.argmax(np.where(width > FINEST, width / rise, 0.0)))
    return float(ends[easiest] + width[easiest] * roots[easiest] / rise[easiest])


ARCHIVED = 4096  # candidates kept


class Archive:
    """Keeps the cheapest candidates on k genes, in order: strings (n, k) and costs (n,)."""

    def __init__(self, genes: int) -> None:
        self.strings = np.empty((0, genes))
        self.costs = np.empty(0)

    def add(self, strings: Array, costs: Array) -> None:
        """Take candidates, shape (n, k), and their costs, shape (n,)."""
        all_costs = np.concatenate([self.costs, costs])
        order = np.argsort(all_costs, kind="stable")[:ARCHIVED]
        self.strings = np.vstack([self.strings, strings])[order]
        self.costs = all_costs[order]


BRED, SECTION, BOWL, QUADRATIC = range(4)  # where a child comes from
_LIBRARIES, _LIMITED = ThreadpoolController(), Lock()
FIRST = 20.0, 0.4, 0.4
"""What is expected of the first three, relative to each other, before anything is known."""

Origins = NDArray[np.int_]


class Surrogates:
    """Replaces some of a generation's children; those of what succeeds more often.

    The last child, whose rival is the worst of the generation, is always the quadratic's.
    """

    def __init__(self, genes: int) -> None:
        self._genes = genes
        self._all = Archive(genes)
        self._shares = Shares(FIRST)
        self.restart()

    def restart(self) -> None:
        """Forget where the search is, but not what was seen."""
        self._near = Archive(self._genes)
        self._sections: Sections | None = None

    def centre(self) -> Array | None:
        """Return where the cost is lowest by and large, shape (k,) if the model has one."""
        return bowl(self._all.strings, self._all.costs)

    def add(self, strings: Array, costs: Array) -> None:
        """Take candidates, shape (n, k), and their costs, shape (n,), 0 .. inf."""
        self._all.add(strings, costs)
        self._near.add(strings, costs)

    def follow(self, origins: Origins, strings: Array, costs: Array, best: float) -> None:
        """Learn what children (n, k) of these origins cost, where the best one cost that much."""
        self._shares.follow(origins[:-1], costs[:-1] < best)
        for index in np.flatnonzero(origins == SECTION):
            if self._sections is not None:
                self._sections.add(strings[index], float(costs[index]))

    def move(self, string: Array, cost: float) -> None:
        """Take the best candidate, shape (k,), of the generation."""
        if self._sections is not None:
            self._sections.move(string, cost)
        elif np.isfinite(cost):
            self._sections = Sections(string, cost)

    def place(self, children: Array, rng: np.random.Generator, *, spread: bool) -> Origins:
        """Replace some of the children (n, k) in place; return where each comes from, (n,).

        Where the population is not spread any more, it breeds nothing new, and sections do.
        """
        # The threads of linear algebra cost more than they bring. Their number belongs to the
        # process: two searches that change it at once would not put it back.
        with _LIMITED, _LIBRARIES.limit(limits=1, user_api="blas"):
            return self._place(children, rng, spread)

    def _place(self, children: Array, rng: np.random.Generator, spread: bool) -> Origins:
        origins = self._shares.draw(len(children), rng)
        if not spread:
            origins[:] = SECTION
        origins[-1] = QUADRATIC
        few, most = 2 * (self._genes + 2), len(self._near.costs)
        lowest: list[Array | None] = [None] * len(children)
        for index in np.flatnonzero(origins == BOWL).tolist():
            n = round(few * (max(most, few) / few) ** rng.random())
            lowest[index] = bowl(self._near.strings[:n], self._near.costs[:n])
        lowest[-1] = bottom(self._near.strings, self._near.costs)
        if self._sections is not None:
            mine = np.flatnonzero(origins == SECTION).tolist()
            for index, child in zip(mine, self._sections.propose(len(mine), rng), strict=True):
                lowest[index] = child
        for index, child in enumerate(lowest):
            if child is not None:
                children[index] = child
        return np.where([child is None for child in lowest], BRED, origins)
