"""FMUs that a reset does not bring back to their start: each of their runs has a new instance."""

from __future__ import annotations

import logging
import threading
from collections.abc import Iterable
from pathlib import Path

_log = logging.getLogger(__name__)
_lock = threading.Lock()

lines: dict[Path, str] = {}
"""What is known in this process: binary -> the line that was logged."""

crashed: set[Path] = set()
"""Binaries that crashed or hung when they were used again: each isolated run has a new child."""


def declare(binaries: Iterable[Path], line: str) -> None:
    """Note that FMUs need new instances; log why, unless that was known of all of them."""
    with _lock:
        new = [binary for binary in binaries if binary not in lines]
        lines.update(dict.fromkeys(new, line))
    if new:
        _log.warning("%s", line)
