"""How far a stage is: told by what takes long, shown by a command, else by nobody."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

T = TypeVar("T")
Show = Callable[[int, int], object]
"""Takes how many steps are done, and of how many."""

_show: ContextVar[Show] = ContextVar("show", default=lambda *_: None)


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
