"""Algorithms on the loop of the paper's drive: the same candidates, several seeds.

    python -m benchmarks.learning.loop [--seeds 10] [--evaluations 300] [ALGORITHM ...]

Prints the cost of the best candidate after a third, two thirds and all of the evaluations, as
median [lowest, highest] over seeds. It is a mean of ratios to a PI controller tuned without a
model. ``random`` draws candidates evenly in the logarithm; ``grid`` takes two or three values of
each gene.
"""

import argparse
from dataclasses import replace
from itertools import product

import numpy as np
from threadpoolctl import threadpool_limits

from stickslip import ga
from stickslip.rigs.fmu import rig_of
from stickslip.servo.tuned_pi import tuned_pi
from stickslip.studies.learn.rig_learning import learn_on_rig
from stickslip.tuning.loop_learning import LoopCost, LoopStudy
from stickslip.tuning.loop_runs import GENES

GRID = (2, 2, 2, 2, 3, 2, 2)
"""Values of each gene in the grid, evenly spaced in the logarithm within its bounds."""


def costs_of(cost: LoopCost, candidates: np.ndarray) -> np.ndarray:
    """Return the costs of candidates (n, k), infinite where they fail."""
    found = []
    for candidate in candidates:
        try:
            found.append(cost(candidate))
        except ga.CandidateFailed:
            found.append(np.inf)
    return np.array(found)


def candidates_at_random(seed: int, n: int) -> np.ndarray:
    """Return candidates (n, k), drawn evenly in the logarithm within the bounds of the genes."""
    return _within(np.random.default_rng(seed).random((n, len(GENES))))


def _within(places: np.ndarray) -> np.ndarray:
    low, high = np.log([[gene.lower, gene.upper] for gene in GENES]).T
    return np.exp(low + (high - low) * places)


def course(study: LoopStudy, cost: LoopCost, name: str, seed: int, evaluations: int) -> np.ndarray:
    """Return the costs of the candidates that an algorithm evaluates, in their order."""
    if name == "random":
        return costs_of(cost, candidates_at_random(seed, evaluations))
    if name == "grid":
        inside = [(np.arange(n) + 0.5) / n for n in GRID]
        places = np.array(list(product(*inside)))
        order = np.random.default_rng(seed).permutation(len(places))[:evaluations]
        return costs_of(cost, _within(places[order]))
    limits = ga.Limits(evaluations=evaluations)
    algorithm = replace(study, algorithm=name, seed=seed, limits=limits).optimiser()
    ga.learn(algorithm, cost)
    return algorithm.history["cost"].to_numpy(dtype=float)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--evaluations", type=int, default=300)
    every = [*ga.ALGORITHMS, "random", "grid"]
    parser.add_argument("algorithms", nargs="*", default=every)
    options = parser.parse_args()
    n = options.evaluations
    with rig_of({}) as rig, threadpool_limits(limits=1, user_api="blas"):
        found = learn_on_rig(rig)
        study = LoopStudy(rig, tuned_pi(found.identification.loop), found.friction)
        with LoopCost(study) as cost:
            for name in options.algorithms:
                rows = []
                for seed in range(options.seeds):
                    best = np.minimum.accumulate(course(study, cost, name, seed, n))
                    rows.append([best[min(k, len(best)) - 1] for k in (n // 3, 2 * n // 3, n)])
                shown = np.sort(np.array(rows), axis=0)
                cells = [
                    f"{np.median(column):.3f} [{column[0]:.3f}, {column[-1]:.3f}]"
                    for column in shown.T
                ]
                print(f"{name:10}" + "".join(f"{cell:>24}" for cell in cells), flush=True)


if __name__ == "__main__":
    main()
