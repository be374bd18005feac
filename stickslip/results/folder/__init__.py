"""A folder of results: locked by one process, replaced as a whole, with a manifest of hashes.

    with reserved(folder, FILES):  # for the whole command; another process is refused
        ...
        with staged(folder, {"name": "learn"}) as staging:
            atomic_write(staging / "learned.json", ...)

``locking.py`` says who may write, ``ownership.py`` which files may be replaced,
``publishing.py`` how a set takes the place of another,
``manifest.py`` what belongs to it, ``verification.py`` whether it is still so.
"""

from stickslip.results.folder.locking import locked, writable
from stickslip.results.folder.manifest import MANIFEST, Manifest
from stickslip.results.folder.ownership import refuse_foreign
from stickslip.results.folder.publishing import complete, remove_results, reserved, staged
from stickslip.results.folder.verification import Verdict, verify

__all__ = [
    "MANIFEST",
    "Manifest",
    "Verdict",
    "complete",
    "locked",
    "refuse_foreign",
    "remove_results",
    "reserved",
    "staged",
    "verify",
    "writable",
]
