"""The figure: cost of a step by master, and how it grows."""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
from matplotlib import pyplot as plt


def draw(
    path: Path,
    steps: dict[str, float],
    growth: dict[str, dict[int, float]],
) -> None:
    """Draw ratios to the plain C loop (steps) and ns per FMU and step (growth)."""
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(13, 5), width_ratios=(1.2, 1), layout="constrained"
    )
    names = sorted(steps, key=steps.__getitem__, reverse=True)
    colours = ["#1b6ca8" if name.startswith("cosim") else "#9aa5b1" for name in names]
    bars = left.barh(names, [steps[name] for name in names], color=colours)
    left.bar_label(bars, fmt="%.3g", padding=3)
    left.set_xscale("log")
    left.margins(x=0.3)
    left.axvline(1.0, color="black", linewidth=0.8)
    left.set_xlabel("cost of a step / plain C loop (1)")
    left.set_title("Ring of three FMI 2.0 FMUs, 100,000 steps")
    for label, costs in growth.items():
        right.plot(list(costs), list(costs.values()), "o-", label=label)
    right.set_xscale("log")
    right.set_ylim(bottom=0.0)
    right.set_xlabel("FMUs in the ring (1)")
    right.set_ylabel("cost of a step per FMU (ns)")
    right.set_title("Growth with the number of FMUs")
    right.legend()
    right.grid(alpha=0.3)
    figure.savefig(path, dpi=150)
    plt.close(figure)
