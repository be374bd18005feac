"""How a result shows itself: as a plot, and as a table in a notebook."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from stickslip.cosim.display import html_table
from stickslip.cosim.signals.signals import Array
from stickslip.fmi.messages import scaled_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_HEIGHT, _WIDTH, _PANEL = 1.0, 7.0, 2.0
"""Of a figure without panels, its width, and the height of a panel [inch]."""


def draw(
    time: Array,
    signals: Mapping[str, Array],
    units: Mapping[str, str | None],
    axes: Axes | Sequence[Axes] | None,
) -> list[Axes]:
    """Draw signals over time, those of one unit in one panel; see ``Result.plot``."""
    panels: dict[str | None, list[str]] = {}
    for name in signals:
        panels.setdefault(units[name], []).append(name)
    if axes is None:
        from matplotlib import pyplot as plt  # late, for those who only simulate

        size = (_WIDTH, _HEIGHT + _PANEL * len(panels))
        figure, grid = plt.subplots(
            len(panels), sharex=True, squeeze=False, figsize=size, layout="constrained"
        )
        figure.align_ylabels()
    else:
        grid = np.atleast_1d(np.asarray(axes, dtype=object))
    given: list[Axes] = list(grid.ravel())
    if len(given) != len(panels):
        raise ValueError(f"expected axes for {len(panels)} units, got {len(given)}")
    seconds, of_time = scaled_unit("s", float(np.abs(time).max(initial=0.0)))
    for panel, (unit, names) in zip(given, panels.items(), strict=True):
        sizes = [np.abs(signals[name][np.isfinite(signals[name])]) for name in names]
        factor, shown = scaled_unit(unit, max(float(size.max(initial=0.0)) for size in sizes))
        for name in names:
            panel.plot(seconds * time, factor * signals[name], label=name, linewidth=1.2)
        if len(names) > 1:
            panel.legend()
        panel.set_ylabel(f"{names[0]} [{shown}]" if len(names) == 1 else f"[{shown}]")
        panel.grid(visible=True, alpha=0.3)
    given[-1].set_xlabel(f"time [{of_time}]")
    return given


def summary(
    time: Array, signals: Mapping[str, Array], units: Mapping[str, str | None], stopped: str | None
) -> str:
    """Return a table of the signals with unit, range and last value, as HTML."""
    rows = []
    for name, values in signals.items():
        ends = (f"{x:.6g}" for x in (values.min(), values.max(), values[-1])) if len(time) else ()
        rows.append((name, units[name] or "", *ends))
    over = f"{len(time)} points" + (f", {time[0]:g} to {time[-1]:g} s" if len(time) else "")
    caption = over + (f"; ended by {stopped}" if stopped else "")
    return html_table(("signal", "unit", "least", "greatest", "last"), rows, caption, words=2)
