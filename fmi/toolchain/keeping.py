"""What takes long to make, and follows from texts alone, stays in the cache."""

import hashlib
from collections.abc import Callable, Iterable
from contextlib import suppress

from stickslip.fmi.files import atomic_write
from stickslip.fmi.toolchain.platforms import cache_directory


def kept(kind: str, parts: Iterable[str], make: Callable[[], bytes]) -> bytes:
    """Return what ``make`` returns; ``parts`` are all that it depends on."""
    digest = hashlib.sha256("\0".join(parts).encode()).hexdigest()[:32]
    path = cache_directory() / kind / digest
    with suppress(OSError):
        return path.read_bytes()
    made = make()
    with suppress(OSError):  # a cache that cannot be written costs time only
        path.parent.mkdir(parents=True, exist_ok=True)
        atomic_write(path, made)
    return made
