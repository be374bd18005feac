"""Progress on a terminal: stages, and a bar; in a pipe stages are printed with ``-v`` only."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Self

from stickslip.output import LOG, Factors, Progress, quiet

if TYPE_CHECKING:
    from tqdm import tqdm

    from stickslip import ga


class TerminalProgress(Progress):
    """The progress that a command shows; close it, or use ``with``."""

    def __init__(self, *, findings: bool = True) -> None:
        self._prints_findings = findings
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

    def done(self, done: int, of: int, what: str, unit: str) -> None:
        """Print what was done last, and move the bar on."""
        if not self._shown:
            LOG.info("%d of %d: %s", done, of, what)
            return
        from tqdm import tqdm

        self.move(done, of, unit)
        tqdm.write(f"{done} of {of}: {what}", file=self._stream)

    def generation(self, algorithm: ga.Optimiser, scale: Factors | None = None) -> None:
        """Move the bar on; a search with a scale has sums of squared forces as its cost."""
        lowest = algorithm.best.cost / (scale.of("F_c") ** 2 if scale else 1.0)
        cost = f"best cost {lowest:.3g}"
        if (generations := algorithm.limits.generations) is not None:
            self.move(algorithm.generation, generations, "generation", cost)
        else:
            self.move(algorithm.evaluations, algorithm.limits.evaluations, "candidate", cost)

    def findings(self, findings: Iterable[object]) -> None:
        """Print findings of the checks of a log."""
        for finding in findings if self._prints_findings else ():
            print(finding)

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
        if self._bar is not None:
            self._bar.close()
            self._bar = None
