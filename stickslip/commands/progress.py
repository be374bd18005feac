"""Progress on a terminal: a line for each stage, and a bar with the remaining time.

In a pipe stages are printed with ``-v`` only.
"""

from __future__ import annotations

import sys
from contextlib import ExitStack
from typing import TYPE_CHECKING, Self

from stickslip.output import LOG, quiet
from stickslip.progress import shown_by

if TYPE_CHECKING:
    from tqdm import tqdm

    from stickslip import ga


class TerminalProgress:
    """The ``Progress`` of a reproduction; close it, or use ``with``."""

    def __init__(self) -> None:
        self._stream = sys.stderr
        self._shown = self._stream.isatty() and not quiet()
        self._bar: tqdm[None] | None = None
        self._open = ExitStack()

    def stage(self, name: str) -> None:
        """Print the stage that begins."""
        self._close_bar()
        if self._shown:
            print(f"{name} ...", file=self._stream, flush=True)
        else:
            LOG.info("%s", name)

    def generation(self, algorithm: ga.Optimiser) -> None:
        """Move the bar on."""
        cost = f"best cost {algorithm.best.cost:.3g}"
        if (generations := algorithm.limits.generations) is not None:
            self._move(algorithm.generation, generations, "generation", cost)
        else:
            self._move(algorithm.evaluations, algorithm.limits.evaluations, "candidate", cost)

    def _move(self, done: int, of: int | None, unit: str = "step", remark: str = "") -> None:
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
        if self._shown:
            self._open.enter_context(shown_by(self._move))
        return self

    def __exit__(self, *_: object) -> None:
        self._open.close()
        self._close_bar()

    def _close_bar(self) -> None:
        if self._bar is not None:
            self._bar.close()
            self._bar = None
