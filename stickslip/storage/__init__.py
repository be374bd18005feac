"""A folder of results: locked by one process, replaced as a whole, with a manifest of hashes.

    with reserved(folder, FILES):  # for the whole command; another process is refused
        ...
        with staged(folder, {"name": "learn"}) as staging:
            atomic_write(staging / "learned.json", ...)

``locking.py`` tells who may write, ``manifest.py`` which files belong to the results,
``publishing.py`` how a set takes the place of another, ``verification.py`` whether it is intact.
"""

from stickslip.storage.locking import locked, writable
from stickslip.storage.manifest import MANIFEST, refuse_foreign
from stickslip.storage.publishing import UNFINISHED, complete, completed, reserved, staged
from stickslip.storage.verification import verify

__all__ = [
    "MANIFEST", "UNFINISHED", "complete", "completed", "locked", "refuse_foreign", "reserved",
    "staged", "verify", "writable",
]  # fmt: skip
