"""Progress: told by what takes long, shown by a command, else by nobody."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, Protocol, TypeVar

if TYPE_CHECKING:
    from stickslip import ga

T = TypeVar("T")
Show = Callable[[int, int], object]  # takes how many steps are done, and of how many

_show: ContextVar[Show] = ContextVar("show", default=lambda *_: None)


class Factors(Protocol):
    """Factors by which the values of a search differ from SI units, as ``Scale``."""

    def of(self, name: str) -> float:
        """Return the factor of a parameter."""


class Progress:
    """Receives the progress of what takes long. This one shows nothing, others derive from it."""

    def stage(self, name: str) -> None:
        """Begin a stage."""

    def generation(self, algorithm: ga.Optimiser, scale: Factors | None = None) -> None:
        """Take a search after another generation; its values have a scale, or are in SI units."""

    def findings(self, findings: Iterable[object]) -> None:
        """Take findings of the checks of a log; as text each is one line."""


SILENT = Progress()


@contextmanager
def shown_by(show: Show) -> Iterator[None]:
    """Call ``show`` for each step that is done inside, in this thread."""
    token = _show.set(show)
    try:
        yield
    finally:
        _show.reset(token)


def step(done: int, of: int) -> None:
    """Tell how many steps of a stage are done."""
    _show.get()(done, of)


def steps(items: Sequence[T]) -> Iterator[T]:
    """Yield items, each a step that is done when the next one is taken."""
    for done, item in enumerate(items):
        step(done, len(items))
        yield item
    step(len(items), len(items))
