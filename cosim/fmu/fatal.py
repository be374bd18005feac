"""FMUs that answered fatal: no instance of theirs, whoever has it, is called again.

Source: FMI 2.0 section 2.1.3, FMI 3.0 section 2.2.3 (fatal corrupts all instances).
"""

from __future__ import annotations

import threading
from collections import Counter
from pathlib import Path

_lock = threading.Lock()
_times: Counter[Path] = Counter()


def declare(binary: Path) -> None:
    """Note that an FMU is corrupted, with all instances that there are."""
    with _lock:
        _times[binary] += 1


def none() -> bool:
    """Return whether no FMU is."""
    return not _times


def times(binary: Path) -> int:
    """Return how often; an instance made when it was less may not be called."""
    return _times[binary]
