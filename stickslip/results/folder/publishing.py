"""A set of results takes the place of an older one.

    1  The new files are written into DIR/.stickslip-writing-*; DIR has the old set.
    2  That folder, complete with its manifest, is renamed to DIR/.stickslip-ready. From here on the
       new set counts.
    3  Its files move to DIR one by one, manifest.json last; what only the old set had is deleted.

Whoever is killed before 2 leaves the old set, untouched. Whoever is killed in 3, which takes some
20 microseconds a file, leaves files of both in DIR and the rest of the new set beside; the next
command that writes there, and ``stickslip verify``, moves that in before it does anything else.
Each single file is always the old one or the new one, whole.

Files that no manifest of ours lists, or that someone has changed, are not touched: where one is in
the place of a new file, nothing is written (``ownership.py``).
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from uuid import uuid4

from stickslip.errors import ResultsError
from stickslip.fmi.files import atomic_write, sync_folder
from stickslip.fmi.process import held
from stickslip.results.folder.locking import OURS, WRITING, locked
from stickslip.results.folder.manifest import MANIFEST, Manifest, hash_of
from stickslip.results.folder.ownership import refuse_foreign, refuse_places, unchanged

READY = f"{OURS}ready"
REMOVED = "was removed while results were written; run again"


@contextmanager
def reserved(folder: Path | None, names: Collection[str]) -> Iterator[None]:
    """Claim a folder for a command that will write these files there, before it computes them.

    None is no folder, and nothing is locked.

    Raises
    ------
    UsageError
        When one of the files is the user's, the folder cannot be written, or another process has
        it.
    """
    with locked(folder):
        if folder is not None:
            complete(folder)
            refuse_foreign(folder, names)
        yield


@contextmanager
def staged(
    folder: Path, command: Mapping[str, Any], without: Collection[str] = ()
) -> Iterator[Path]:
    """Give a folder to write in; at the end of the block its files are the folder's new set.

    Parameters
    ----------
    folder : is made if it is absent
    command : name and options of the command, for manifest.json, which is written here
    without : names of files that must not stay, unless written now, whichever command wrote them

    Raises
    ------
    UsageError
        When another process writes there, or a file to be replaced is the user's.
    ResultsError
        When the folder is removed meanwhile.
    OSError
        When a file cannot be written; the old set is then as it was.
    """
    with locked(folder):
        complete(folder)
        staging = folder / f"{WRITING}{uuid4().hex}"
        token = staging / uuid4().hex  # gone if the folder is removed and made again meanwhile
        try:
            staging.mkdir()
            token.touch()
            yield staging
            if not token.exists():
                raise ResultsError(f"{folder}: {REMOVED}")
            token.unlink()
            with held():  # an interruption in its midst would leave files of both sets
                _commit(staging, folder, command, without)
                _move_in(folder)
        except OSError as error:
            raise _of(error, staging, folder) from error
        finally:
            shutil.rmtree(staging, ignore_errors=True)


def complete(folder: Path) -> None:
    """Move in what a killed process left ready.

    Raises
    ------
    UsageError
        When another process writes there, or this one may not.
    OSError
        When a file cannot be moved.
    """
    if os.path.lexists(folder / READY):
        with locked(folder), held():
            _move_in(folder)


def _commit(
    staging: Path, folder: Path, command: Mapping[str, Any], without: Collection[str]
) -> None:
    """Write the manifest and give the folder the name from which on it counts."""
    names = files_in(staging)
    manifest = Manifest(dict(command), {name: hash_of(staging / name) for name in names})
    with suppress(ResultsError):  # a folder without manifest
        older = Manifest.read(folder)
        gone = [name for name in older.sha256 if not (folder / name).exists()]
        manifest = older.without(frozenset([*gone, *without])).followed_by(manifest)
    atomic_write(staging / MANIFEST, manifest.text())
    refuse_places(folder, MANIFEST)
    refuse_foreign(folder, {*names, *without})
    for path in {(staging / name).parent for name in names}:
        sync_folder(path)
    staging.replace(folder / READY)
    sync_folder(folder)


def _move_in(folder: Path) -> None:
    ready = folder / READY
    try:
        refuse_places(folder, f"{READY}/{MANIFEST}")
        names = files_in(ready)
        refuse_places(folder, MANIFEST)
        refuse_foreign(folder, set(names) - {MANIFEST})
        places = {(folder / name).parent for name in names}
        for place in places:
            place.mkdir(parents=True, exist_ok=True)
        leaving = _leaving(folder, ready)
        with _linked([*(folder / name for name in names), *leaving], folder):
            # Here a reader may see files of both sets, so nothing slow belongs here.
            for name in sorted(names, key=MANIFEST.__eq__):  # the manifest comes last
                if name == MANIFEST:
                    for path in leaving:
                        path.unlink(missing_ok=True)
                (ready / name).replace(folder / name)
        for place in places:
            sync_folder(place)
        shutil.rmtree(ready)
        sync_folder(folder)
        if not all((folder / name).exists() for name in names):
            raise ResultsError(f"{folder}: {REMOVED}")
    except OSError as error:
        raise ResultsError(
            f"{folder}: new results are complete but not all in place ({error.filename}: "
            f"{error.strerror}); mend that, and 'stickslip verify {folder}' moves the rest"
        ) from error


@contextmanager
def _linked(paths: Collection[Path], folder: Path) -> Iterator[None]:
    """Hold on to files, where links can be made: to free their blocks takes long, to rename not."""
    room = folder / f"{WRITING}{uuid4().hex}"
    try:
        with suppress(OSError):
            room.mkdir()
        for k, path in enumerate(paths):
            with suppress(OSError):
                os.link(path, room / str(k))
        yield
    finally:
        shutil.rmtree(room, ignore_errors=True)


def _leaving(folder: Path, ready: Path) -> list[Path]:
    """Return the files that only the old set has, unless someone has changed them since."""
    with suppress(ResultsError):
        old, new = Manifest.read(folder), Manifest.read(ready)
        return unchanged(folder, old, old.sha256.keys() - new.sha256.keys())
    return []


def files_in(folder: Path) -> list[str]:
    """Return the names of all files below a folder, links to folders among them."""
    found = []
    for place, folders, files in os.walk(folder):
        links = [name for name in folders if Path(place, name).is_symlink()]
        found += [Path(place, name).relative_to(folder).as_posix() for name in (*files, *links)]
    return sorted(found)


def remove_results(folder: Path) -> None:
    """Delete the files that the manifest lists, the manifest, and what folders are empty then.

    Files that someone has changed or added stay.
    """
    with suppress(ResultsError), locked(folder):
        manifest = Manifest.read(folder)
        ours = unchanged(folder, manifest, manifest.sha256.keys())
        for path in (*ours, folder / MANIFEST):
            path.unlink(missing_ok=True)
        for place in sorted({path.parent for path in ours}, reverse=True):
            with suppress(OSError):
                place.rmdir()
    with suppress(OSError):
        folder.rmdir()


def _of(error: OSError, staging: Path, folder: Path) -> OSError:
    """Return an error that names the file as it will be called."""
    name = str(error.filename or folder).replace(str(staging), str(folder))
    return OSError(error.errno, error.strerror, name)
