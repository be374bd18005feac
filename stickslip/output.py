"""What a command prints: text or JSON on standard output, messages on standard error."""

from __future__ import annotations

import argparse
import json
import logging
import math
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TextIO, cast

from stickslip.fmi.messages import harmless

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


class _Harmless:
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
        with redirect_stdout(cast("TextIO", _Harmless(sys.stdout))):
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
    if hasattr(value, "to_dict"):  # a table of pandas, which need not be loaded to know
        return plain(value.to_dict("records"))
    if hasattr(value, "tolist"):  # an array or scalar of numpy
        return plain(value.tolist())
    if isinstance(value, (list, tuple, set, frozenset)):
        return [plain(one) for one in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, (bool, int, str)) else str(value)
