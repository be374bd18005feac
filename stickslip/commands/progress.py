"""Progress: lines for stages and a bar for generations on a terminal; with ``-v`` in a pipe too."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Self

from stickslip.output import LOG, quiet

if TYPE_CHECKING:
    from tqdm import tqdm

    from stickslip import ga


class TerminalProgress:
    """The ``Progress`` of a reproduction; close it, or use ``with``."""

    def __init__(self) -> None:
        self._stream = sys.stderr
        self._shown = self._stream.isatty() and not quiet()
        self._bar: tqdm[None] | None = None

    def stage(self, name: str) -> None:
        """Print the stage that begins."""
        self._close_bar()
        if self._shown:
            print(f"{name} ...", file=self._stream, flush=True)
        else:
            LOG.info("%s", name)

    def generation(self, algorithm: ga.Optimiser) -> None:
        """Move the bar on."""
        if self._bar is None:
            from tqdm import tqdm  # late, for those who start quickly

            self._bar = tqdm(
                total=algorithm.limits.generations,
                unit="generation",
                disable=not self._shown,
                file=self._stream,
            )
        self._bar.update(algorithm.generation - self._bar.n)
        self._bar.set_postfix_str(f"best cost {algorithm.best.cost:.3g}", refresh=False)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._close_bar()

    def _close_bar(self) -> None:
        if self._bar is not None:
            self._bar.close()
            self._bar = None
