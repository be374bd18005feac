"""Text, JSON or nothing on standard output, and who shows the progress of what is long."""

from __future__ import annotations

import argparse
import json
import logging
import math
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stdout
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, Self, TextIO, TypeVar, cast

from stickslip.fmi.messages import harmless

if TYPE_CHECKING:
    from stickslip import ga

LOG = logging.getLogger("stickslip")


@dataclass(frozen=True)
class Answer:
    """What a command returns."""

    # what ``--json`` prints: mappings and lists, also of paths, numpy values and tables
    document: Mapping[str, Any] = field(default_factory=dict)
    status: int = 0  # exit status


class _Lines(logging.Handler):
    """Prints each message as a line of the command."""

    def emit(self, record: logging.LogRecord) -> None:
        kind = "warning: " if record.levelno == logging.WARNING else ""
        line = harmless(record.getMessage())
        print(f"stickslip: {kind}{line}", file=sys.stderr, flush=True)  # noqa: T201


class _HarmlessStream:
    """Standard output, on which text from files is harmless."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        return self._stream.write(harmless(text))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextmanager
def messages(options: argparse.Namespace) -> Iterator[None]:
    """Print what is logged: warnings and errors, ``--verbose`` all, ``--quiet`` errors."""
    level, lines = LOG.level, _Lines()
    usual = logging.INFO if options.verbose else logging.WARNING
    LOG.setLevel(logging.ERROR if options.quiet else usual)
    LOG.addHandler(lines)
    try:
        yield
    finally:
        LOG.removeHandler(lines)
        LOG.setLevel(level)


def quiet() -> bool:
    """Tell whether only errors are printed."""
    return not LOG.isEnabledFor(logging.WARNING)


def answered(options: argparse.Namespace, run: Callable[..., Answer | None]) -> int:
    """Run a command; print its text, its document as JSON, or nothing; return its exit status."""
    if not (options.json or options.quiet):
        with redirect_stdout(cast("TextIO", _HarmlessStream(sys.stdout))):
            return (run(options) or Answer()).status
    with Path(os.devnull).open("w", encoding="utf-8") as nothing, redirect_stdout(nothing):
        answer = run(options) or Answer()
    if options.json:
        print(json.dumps(plain(answer.document), indent=2, allow_nan=False))  # noqa: T201
    return answer.status


def plain(value: Any) -> Any:
    """Return a value as JSON has it; a number that is not finite is null."""
    if isinstance(value, Mapping):
        return {str(key): plain(one) for key, one in value.items()}
    if hasattr(value, "records"):  # a table of results
        return plain(value.records())
    if hasattr(value, "to_dict"):  # a table of pandas, which need not be loaded to know
        return plain(value.to_dict("records"))
    if hasattr(value, "tolist"):  # an array or scalar of numpy
        return plain(value.tolist())
    if isinstance(value, (list, tuple, set, frozenset)):
        return [plain(one) for one in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, (bool, int, str)) else str(value)


T = TypeVar("T")
Show = Callable[[int, int | None], object]
"""Takes how many steps are done, and of how many, if that is known."""

_show: ContextVar[Show] = ContextVar("show", default=lambda *_: None)


class Factors(Protocol):
    """Factors by which the values of a search differ from SI units, as ``Scale``."""

    def of(self, name: str) -> float:
        """Return the factor of a parameter."""


class Progress:
    """Receives the progress of what takes long. This one shows nothing, others derive from it.

    Within ``with``, it also receives the steps of a stage in this thread.
    """

    def __enter__(self) -> Self:
        self._shown_by = shown_by(self.move)
        self._shown_by.__enter__()
        return self

    def __exit__(self, *failure: Any) -> None:
        self._shown_by.__exit__(*failure)

    def move(self, done: int, of: int | None, unit: str = "step", remark: str = "") -> None:
        """Take how many steps of a stage are done, and of how many."""

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


@contextmanager
def counted_steps() -> Iterator[None]:
    """Show the steps of all stages inside as one count, whose end is not known."""
    show, total = _show.get(), 0

    def count(done: int, _: int | None) -> None:
        nonlocal total
        total += done > 0
        show(total, None)

    with shown_by(count):
        yield


def step(done: int, of: int) -> None:
    """Tell how many steps of a stage are done."""
    _show.get()(done, of)


def steps(items: Sequence[T]) -> Iterator[T]:
    """Yield items, each a step that is done when the next one is taken."""
    for done, item in enumerate(items):
        step(done, len(items))
        yield item
    step(len(items), len(items))
