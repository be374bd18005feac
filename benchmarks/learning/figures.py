"""The figure: cost over evaluations."""

from pathlib import Path

import matplotlib as mpl
import numpy as np

mpl.use("Agg")
from matplotlib import pyplot as plt

OURS, PAPER, OTHERS = "#1b6ca8", "#c0392b", ["#7f8c8d", "#b5651d", "#2e8b57", "#8e6bbf", "#d4a017"]


def race(path: Path, problems: dict[str, dict[str, np.ndarray]]) -> None:
    """Draw median and quartiles of the best cost (seeds, evaluations) of every racer."""
    figure, all_axes = plt.subplots(
        1, len(problems), figsize=(6.5 * len(problems), 5), layout="constrained", squeeze=False
    )
    titles = {"measured": "Encoder of 0.4 µm", "smooth": "Without encoder and DAC steps"}
    for axes, (kind, curves) in zip(all_axes[0], problems.items(), strict=True):
        others = iter(OTHERS)
        for name, costs in curves.items():
            mine = {"ours, default": OURS, "ours, paper's preset": PAPER}.get(name)
            colour = mine or next(others)
            x = np.arange(1, costs.shape[1] + 1)
            low, median, high = np.quantile(costs, [0.25, 0.5, 0.75], axis=0)
            axes.plot(x, median, color=colour, linewidth=2.2 if mine else 1.4, label=name)
            if mine:
                axes.fill_between(x, low, high, color=colour, alpha=0.15, linewidth=0)
        axes.set_yscale("log")
        axes.set_xlim(0, costs.shape[1])
        axes.set_xlabel("evaluations (1)")
        axes.set_ylabel("best cost, median of the seeds (m²/s²)")
        axes.set_title(titles[kind])
        axes.grid(alpha=0.3)
    all_axes[0][0].legend(fontsize=9)
    figure.savefig(path, dpi=130)
    plt.close(figure)
