"""Fig. 4: the flow chart of the learning, Steps 1 to 4, with the numbers of this run."""

from __future__ import annotations

from itertools import pairwise

from matplotlib.figure import Figure

from stickslip import ga
from stickslip.pipeline.reproduction import Reproduction
from stickslip.report.diagram import Block, Sheet
from stickslip.report.quantity import number
from stickslip.report.style import (
    PAGE,
    PALE,
    new_figure,
)
from stickslip.servo.datasheet import TRAINING
from stickslip.tuning.learning import BOUNDS

HEIGHT = 112.0

Operation = tuple[str, str]


def draw(reproduction: Reproduction) -> Figure:
    """Draw the flow chart."""
    algorithm = reproduction.algorithm
    figure = new_figure(PAGE, HEIGHT, free=True)
    sheet = Sheet(figure)
    first = sheet.block(Block(46, 101, 76, 16), "Step 1. Initialization", _initial(algorithm))
    fitness = sheet.block(
        Block(46, 77, 76, 16),
        "Step 2. Fitness calculation",
        f"each candidate runs for {number(TRAINING.duration)} s: $v$; the nominal loop: $v_r$\n"
        r"cost $1/J = \sum (v - v_r)^2$, equation (6)",
    )
    ended = sheet.decision(Block(46, 46, 80, 30), "Step 3. Evaluation", _end(algorithm.limits))
    learned = sheet.block(Block(46, 14, 76, 16), "Learned parameters", _learned(reproduction), PALE)
    operations = _operations(algorithm)
    lowest = _heights(len(operations), fitness.y)[0] - 11.0
    sheet.group((100, lowest), 80, 93 - lowest, "Step 4. New generation")
    blocks = [
        sheet.block(Block(140, y, 70, 14.5), *operation)
        for y, operation in zip(_heights(len(operations), fitness.y), operations, strict=True)
    ]

    for upper, lower in ((first, fitness), (fitness, ended), (ended, learned)):
        sheet.arrow((upper.x, upper.bottom), (lower.x, lower.top))
    for lower, upper in pairwise(blocks):
        sheet.arrow((lower.x, lower.top), (upper.x, upper.bottom))
    turn = 94.0
    sheet.arrow(ended.right, (turn, ended.y), (turn, blocks[0].y), blocks[0].left)
    sheet.arrow(blocks[-1].left, fitness.right)
    sheet.text((90, ended.y + 2.6), "no", small=True)
    sheet.text((50.5, (ended.bottom + learned.top) / 2), "yes", small=True)
    return figure


def _heights(n: int, top: float) -> list[float]:
    """Return the heights of n blocks, the last at the top."""
    return [top - 17.5 * (n - 1 - k) for k in range(n)]


def _initial(algorithm: ga.Optimiser) -> str:
    size = algorithm.history["generation"].eq(algorithm.history["generation"].iloc[0]).sum()
    low, high = (number(bound) for bound in BOUNDS)
    return (
        f"{size} candidates, the identified parameters among them;\n"
        f"each gene from {low} to {high} times its identified value"
    )


def _end(limits: ga.Limits) -> str:
    """Return the question of Step 3."""
    counts = {"generations": limits.generations, "evaluations": limits.evaluations}
    parts = [f"{count} {name} done" for name, count in counts.items() if count is not None]
    if limits.target is None:
        parts.append("cost at most ε (not set)?")
    else:
        parts.append(f"cost at most ε = {number(limits.target)} m²/s²?")
    return ",\nor ".join(parts)


def _learned(reproduction: Reproduction) -> str:
    algorithm = reproduction.algorithm
    best = (
        f"the best of {number(algorithm.evaluations, 6)} candidates "
        f"in {number(algorithm.generation, 6)} generations"
    )
    if reproduction.learned.skipped:
        return "what it began with: after one generation\nthe drive had no more to teach"
    if reproduction.options.refined and reproduction.learned.accepted:
        return f"{best},\nrefined by least squares"
    return best


def _operations(algorithm: ga.Optimiser) -> list[Operation]:
    """Return what makes a new generation, in its order."""
    if not isinstance(algorithm, ga.GeneticAlgorithm):
        told = "Evaluated candidates", "all so far, with their costs"
        return [
            told,
            (algorithm.title[0].upper() + algorithm.title[1:], f"{algorithm.batch} new candidates"),
        ]
    settings = algorithm.settings
    children = settings.population - settings.elites
    keeps = (
        "generational" if settings.survival == "generational" else "a child must beat its parent"
    )
    crossover = f"{settings.crossover}, rate {number(settings.crossover_rate)}"
    if settings.crossover == "arithmetic":
        crossover = (
            rf"arithmetic, adaptive probability (7), $k_1$ = {number(settings.k1)}, "
            rf"$k_2$ = {number(settings.k2)}"
        )
    rate = f"rate {number(settings.mutation_rate)}{' at first, adaptive' * settings.adaptive}"
    return [
        ("Selection", f"elite of {settings.elites} in {settings.population}, {keeps}"),
        ("Crossover", crossover),
        ("Mutation", f"{settings.mutation}, {rate}"),
        ("Next generation", f"the elite and {children} new candidates{_beyond(settings)}"),
    ]


def _beyond(settings: ga.Settings) -> str:
    """Return what the paper's algorithm does not have."""
    parts = []
    if settings.surrogates:
        parts.append("some from models of the cost")
    if settings.patience is not None:
        parts.append(f"restart after {settings.patience} without progress")
    return "".join(f"\n{part}" if k == 0 else f", {part}" for k, part in enumerate(parts))
