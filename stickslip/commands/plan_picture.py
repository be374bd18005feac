"""What an experiment looks like."""

import io
from itertools import pairwise

import pandas as pd
from matplotlib.axes import Axes

from stickslip.logs.units import Unit
from stickslip.planning.experiment import Stretch
from stickslip.presentation.style import (
    GREY,
    PAGE,
    RESOLUTION,
    SHADE,
    SMALL,
    THIN,
    WITH,
    house_style,
    new_figure,
)


def draw_plan(table: pd.DataFrame, stretches: tuple[Stretch, ...], length: Unit) -> bytes:
    """Return a PNG file of a plan: velocity, position, and the first two parts enlarged.

    The table and the stretches are those of ``plan`` and ``arrange``. Large moves are drawn in this
    unit of length, mm for m.
    """
    unit = "mm" if length.name == "m" else length.name
    large = 1e3 if length.name == "m" else 1 / length.factor
    small, fine = (1e6, "µm") if length.quantity == "length" else (1e3 * large, f"m{unit}")
    with house_style():
        figure = new_figure(PAGE, 125.0)
        grid = figure.add_gridspec(3, 2, height_ratios=(1.25, 1.0, 1.25))
        velocity = figure.add_subplot(grid[0, :])
        position = figure.add_subplot(grid[1, :], sharex=velocity)
        moves, slow = figure.add_subplot(grid[2, 0]), figure.add_subplot(grid[2, 1])
        _draw(velocity, table, "velocity_command", large, label=f"(a) velocity [{unit}/s]")
        _draw(position, table, "position_command", large, label=f"(b) position [{unit}]")
        _shade((velocity, position), table, stretches)
        first, second = (table[s.begin : s.end] for s in stretches[:2])
        _draw(moves, first, "position_command", small, label=f"(c) small moves [{fine}]")
        moves.set_yscale("symlog", linthresh=1.0)
        moves.set_ylim(bottom=0.0)
        _draw(slow, second, "velocity_command", large, label=f"(d) slow reversals [{unit}/s]")
        for axes in (position, moves, slow):
            axes.set_xlabel("time [s]")
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=RESOLUTION, metadata={"Software": None})
    return stream.getvalue()


def _draw(axes: Axes, table: pd.DataFrame, column: str, scale: float, label: str) -> None:
    axes.plot(table["time"], table[column] * scale, color=WITH, linewidth=THIN)
    axes.set(ylabel=label, xlim=(table["time"].iloc[0], table["time"].iloc[-1]))


def _shade(panels: tuple[Axes, Axes], table: pd.DataFrame, stretches: tuple[Stretch, ...]) -> None:
    """Shade every other part, and name all above the upper panel."""
    ends = [*(s.begin for s in stretches), stretches[-1].end]
    times = table["time"].to_numpy()[ends]
    top = panels[0]
    for k, (begin, end) in enumerate(pairwise(times)):
        for axes in panels if k % 2 == 0 else ():
            axes.axvspan(begin, end, color=SHADE, linewidth=0)
        top.text(
            0.5 * (begin + end),
            1.03,
            stretches[k].part.name.replace(" ", "\n"),
            transform=top.get_xaxis_transform(),
            ha="center",
            va="bottom",
            color=GREY,
            fontsize=SMALL,
        )
