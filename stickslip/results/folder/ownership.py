"""Which files of a folder are ours: those that its manifest lists and nobody has changed since."""

from __future__ import annotations

import errno
import os
from collections.abc import Collection
from contextlib import suppress
from pathlib import Path

from stickslip.errors import ResultsError, UsageError
from stickslip.fmi.files import require_regular_file
from stickslip.results.folder.manifest import MANIFEST, Manifest, hash_of


def refuse_foreign(folder: Path, names: Collection[str]) -> None:
    """Refuse to replace or delete files that the manifest does not list as they are.

    Parameters
    ----------
    names : of the files, with ``/`` between the parts; those that are absent are no obstacle

    Raises
    ------
    UsageError
        When there is a file of another origin, or one that was changed; it names the first.
    OSError
        When a link, a folder or a device is in the way; it names it.
    """
    listed = _listed(folder)
    foreign = []
    for name in sorted(names):
        refuse_places(folder, name)
        with suppress(FileNotFoundError, NotADirectoryError):
            if hash_of(folder / name) != listed.get(name):
                foreign.append(name)
    if foreign:
        first, *more = foreign
        why = (
            "was changed after stickslip had written it"
            if first in listed
            else f"exists, and no {MANIFEST} lists it as a result of stickslip"
        )
        others = f" (nor {len(more)} other file{'s' * (len(more) > 1)})" if more else ""
        raise UsageError(
            f"{folder / first}: {why}; it is not overwritten{others}: move it away, or choose "
            "another folder with --out"
        )


def refuse_places(folder: Path, name: str) -> None:
    """Refuse to put a file where a link, a folder or a file is in its way.

    Raises
    ------
    OSError
        When there is one; it names it.
    """
    *parents, last = name.split("/")
    place = folder
    for part in parents:
        place = place / part
        if place.is_symlink() or (place.exists() and not place.is_dir()):
            raise OSError(errno.ENOTDIR, "is in the way, expected a folder", str(place))
    require_regular_file(place / last)


def unchanged(folder: Path, manifest: Manifest, names: Collection[str]) -> list[Path]:
    """Return those of the files that are as the manifest lists them."""
    found = []
    for name in names:
        with suppress(OSError):
            refuse_places(folder, name)
            if hash_of(folder / name) == manifest.sha256[name]:
                found.append(folder / name)
    return found


def _listed(folder: Path) -> dict[str, str]:
    if not os.path.lexists(folder / MANIFEST):
        return {}
    try:
        return dict(Manifest.read(folder).sha256)
    except ResultsError as error:
        raise UsageError(
            f"{error}; it is not overwritten: move it away, or choose another folder with --out"
        ) from None
