"""The cost over one gene while the others stay: sections through the best candidate.

Where genes act independently, the cost is a sum of its sections. Each can then be searched from end
to end by itself, however many minima it has, and their best values can be put together.
"""

from __future__ import annotations

import numpy as np

from stickslip.ga.arrays import Array

FINEST = 1e-9
"""A gene is not evaluated closer than this to a value that it had, on [0, 1]."""

FITTED = 0.5
"""Probability that a proposal is the minimum of a parabola, not the easiest interval."""

DEMANDS = 3
"""Decades below the range of the costs over which a wished improvement is drawn."""

_Section = tuple[Array, Array]
"""values of a gene in ascending order, and costs relative to those of the other sections"""


class Sections:
    """Sections along each of k axes, with costs that add up.

    Parameters
    ----------
    string : the best candidate, which they go through, shape (k,)
    cost : of it, finite
    """

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
    next to the best value, large ones in wide gaps.

    Source
    ------
    Langerman, Seront and Bersini, STEP: The Easiest Way to Optimize a Function, IEEE Conference
    on Evolutionary Computation (1994) 519.
    """
    ends = np.concatenate([[0.0], values, [1.0]])
    height = np.concatenate([costs[:1], costs, costs[-1:]]) - costs.min()
    share = 10.0 ** rng.uniform(-DEMANDS, 0)
    wish = max((float(height.max()) or 1.0) * share, np.finfo(float).tiny)  # never rounded to 0
    roots = np.sqrt(height + wish)
    width, rise = np.diff(ends), roots[:-1] + roots[1:]
    easiest = int(np.argmax(np.where(width > FINEST, width / rise, 0.0)))
    return float(ends[easiest] + width[easiest] * roots[easiest] / rise[easiest])
