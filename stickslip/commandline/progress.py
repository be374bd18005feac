"""Progress on a terminal: a line for each stage, and a bar with the remaining time.

``--live`` adds lines below the bar: the cost over the generations, and each parameter with its
spread. In a pipe stages are printed with ``-v`` only.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from stickslip.commandline import FLAG, add_options, warn
from stickslip.output import LOG, Factors, Progress, quiet

if TYPE_CHECKING:
    from tqdm import tqdm

    from stickslip import ga
    from stickslip.cosim.signals.signals import Array


LEVELS = "▁▂▃▄▅▆▇█"
LATEST = 40  # generations of which the cost is drawn
Row = tuple[float, str]  # a share from 0 to 1, drawn as a bar unless it is NaN, and a text


def add_live_option(parser: argparse._ActionsContainer) -> None:
    """Declare ``--live``."""
    live = "show cost, spread of the parameters and remaining time while it runs, on a terminal"
    add_options(parser, {"--live": live}, **FLAG)


class TerminalProgress(Progress):
    """The progress that a command shows; close it, or use ``with``."""

    def __init__(self, *, live: bool = False, findings: bool = True) -> None:
        self._prints_findings = findings
        self._stream = sys.stderr
        self._shown = self._stream.isatty() and not quiet()
        self._live = live and self._shown
        if live and not self._shown:
            warn("--live: expected a terminal on standard error; nothing is shown")
        self._bar: tqdm[None] | None = None
        self._rows: dict[str, tqdm[None]] = {}
        self._begun: dict[str, float] = {}

    def stage(self, name: str) -> None:
        """Print the stage that begins."""
        self._close_bar()
        if self._shown:
            print(f"{name} ...", file=self._stream, flush=True)
        else:
            LOG.info("%s", name)

    def done(
        self, done: int, of: int, what: str, unit: str, rows: Mapping[str, Row] | None = None
    ) -> None:
        """Print what was done last, and move the bar on; draw rows with ``--live``."""
        if not self._shown:
            LOG.info("%d of %d: %s", done, of, what)
            return
        from tqdm import tqdm

        self.move(done, of, unit)
        tqdm.write(f"{done} of {of}: {what}", file=self._stream)
        self._draw(rows or {})

    def generation(self, algorithm: ga.Optimiser, scale: Factors | None = None) -> None:
        """Move the bar on; a search with a scale has sums of squared forces as its cost."""
        lowest = algorithm.best.cost / (scale.of("F_c") ** 2 if scale else 1.0)
        cost = f"best cost {lowest:.3g}"
        if (generations := algorithm.limits.generations) is not None:
            self.move(algorithm.generation, generations, "generation", cost)
        else:
            self.move(algorithm.evaluations, algorithm.limits.evaluations, "candidate", cost)
        if self._live:
            self._draw(self._of_search(algorithm, scale))

    def findings(self, findings: Iterable[object]) -> None:
        """Print findings of the checks of a log."""
        for finding in findings if self._prints_findings else ():
            print(finding)

    def _of_search(self, algorithm: ga.Optimiser, scale: Factors | None) -> dict[str, Row]:
        """Return the cost, and each parameter's spread in this generation and beside the first."""
        history = algorithm.history
        latest = history[history["generation"] == algorithm.generation]
        rows = {"cost": (math.nan, sparkline(algorithm.convergence()["best_cost"].to_numpy()))}
        for name, value in zip(algorithm.names, algorithm.best.values.tolist(), strict=True):
            low, high = np.percentile(latest[name], [25, 75])
            if algorithm.generation == 1:
                self._begun[name] = high - low
            begun = self._begun.get(name, 0.0)
            share = min(1.0, (high - low) / begun) if begun else 0.0
            value, low, high = np.array([value, low, high]) / (scale.of(name) if scale else 1.0)
            rows[name] = share, f"{value:.5g}, half of the candidates in {low:.4g} .. {high:.4g}"
        return rows

    def _draw(self, rows: Mapping[str, Row]) -> None:
        """Draw rows below the bar."""
        from tqdm import tqdm

        if not self._live:
            return
        width = max(map(len, rows), default=0)
        for place, (name, (share, text)) in enumerate(rows.items(), 1):
            if name not in self._rows:
                looks = {"bar_format": "{desc}", "leave": False, "file": self._stream}
                self._rows[name] = tqdm(total=1.0, position=place, **looks)
            row, bar = self._rows[name], "" if math.isnan(share) else "|{bar:20}| "
            row.bar_format = f"  {name:{width}} {bar}{text}"
            row.n = 0.0 if math.isnan(share) else share
            row.refresh()

    def move(self, done: int, of: int | None, unit: str = "step", remark: str = "") -> None:
        """Move the bar; what is less far than it, or has another end, is another bar."""
        if not self._shown:
            return
        if self._bar is None or done < self._bar.n or of != self._bar.total:
            from tqdm import tqdm  # late, for those who start quickly

            self._close_bar()
            self._bar = tqdm(total=of, unit=unit, leave=unit != "step", file=self._stream)
        self._bar.set_postfix_str(remark, refresh=False)
        self._bar.update(done - self._bar.n)

    def __enter__(self) -> Self:
        return super().__enter__() if self._shown else self

    def __exit__(self, *failure: Any) -> None:
        if self._shown:
            super().__exit__(*failure)
        self._close_bar()

    def _close_bar(self) -> None:
        for row in reversed(self._rows.values()):
            row.close()
        self._rows.clear()
        if self._bar is not None:
            self._bar.close()
            self._bar = None


def spread_of(learned: Mapping[str, Sequence[float]]) -> dict[str, Row]:
    """Return rows of parameters: half of their values, and that range beside the median."""
    rows = {}
    for name, values in learned.items():
        low, middle, high = np.percentile(values, [25, 50, 75]).tolist()
        share = min(1.0, (high - low) / abs(middle)) if middle else 0.0
        rows[name] = share, f"median {middle:.5g}, half of the drives in {low:.4g} .. {high:.4g}"
    return rows


def sparkline(values: Array) -> str:
    """Return the last of some numbers above 0 (n,) as a line of blocks, on a logarithmic scale."""
    shown = values[np.isfinite(values) & (values > 0.0)][-LATEST:]
    if not len(shown):
        return ""
    scaled = np.log(shown / shown.min())
    most = scaled.max() or 1.0
    return "".join(LEVELS[round(7 * one)] for one in scaled / most)
