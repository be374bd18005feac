"""A set of results takes the place of an older one.

    1  The new files are written into DIR/.stickslip-writing-*; DIR has the old set.
    2  That folder, complete with its manifest, is renamed to DIR/.stickslip-ready. From here on the
       new set counts.
    3  Its files move to DIR one by one, manifest.json last; what only the old set had is deleted.

A process that is killed before 2 leaves the old set. One that is killed in 3 leaves files of both
sets in DIR and the rest of the new one in .stickslip-ready; the next command that writes there, and
``stickslip verify``, move that in before anything else. Each single file is always whole.

Files that no manifest lists, or that were changed since, stay as they are: where one is in the
place of a new file, nothing is written.
"""

import gzip
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
from stickslip.output import LOG
from stickslip.storage.locking import PREFIX, WRITING, is_locked, locked
from stickslip.storage.manifest import (
    MANIFEST,
    Manifest,
    hash_of,
    refuse_foreign,
    refuse_places,
    unchanged,
)

READY = f"{PREFIX}ready"
UNFINISHED = "unfinished"  # The folder of what a command with many jobs has found so far


@contextmanager
def reserved(folder: Path | None, names: Collection[str]) -> Iterator[None]:
    """Lock a folder for a command that will write these files there, before it computes them.

    That they replace earlier ones is told. None locks nothing. Raises UsageError when one of the
    files is the user's, the folder cannot be written, or another process has locked it.
    """
    with locked(folder):
        if folder is not None:
            complete(folder)
            refuse_foreign(folder, names)
            with suppress(ResultsError):  # a folder without manifest
                if not Manifest.read(folder).sha256.keys().isdisjoint(names):
                    LOG.warning("%s: has results of an earlier run, which are replaced", folder)
        yield


@contextmanager
def staged(
    folder: Path, command: Mapping[str, Any], without: Collection[str] = ()
) -> Iterator[Path]:
    """Give a folder to write in; at the end of the block its files are the folder's new set.

    The folder is made if it is absent. manifest.json has name and options of the command. Files
    ``without`` must not stay, unless written now, whichever command wrote them. Raises UsageError
    when another process writes there, or a file to be replaced is the user's, or ResultsError when
    the folder is removed meanwhile, or OSError when a file cannot be written; the old set is then
    as it was.
    """
    with locked(folder):
        complete(folder)
        staging = folder / f"{WRITING}{uuid4().hex}"
        try:
            staging.mkdir()
            yield staging
            with held():  # an interruption in its midst would leave files of both sets
                _commit(staging, folder, command, without)
                _move_in(folder)
        except OSError as error:  # names the file as it will be called
            name = str(error.filename or folder).replace(str(staging), str(folder))
            raise OSError(error.errno, error.strerror, name) from error
        finally:
            shutil.rmtree(staging, ignore_errors=True)


@contextmanager
def completed(
    folder: Path, command: Mapping[str, Any], without: Collection[str], tables: Mapping[str, Any]
) -> Iterator[Path]:
    """Give a folder as ``staged`` does, for the results of all jobs.

    Adds the tables (pandas, by file name: .csv or .csv.gz), and removes what was kept while the
    jobs ran. Raises UsageError, ResultsError, OSError as ``staged``.
    """
    with staged(folder, command, without) as staging:
        yield staging
        for name, table in tables.items():
            text = table.to_csv(index=False, lineterminator="\n")
            packed = gzip.compress(text.encode(), mtime=0) if name.endswith(".gz") else text
            atomic_write(staging / name, packed)
    remove_results(folder / UNFINISHED)


def complete(folder: Path) -> None:
    """Move in what a killed process left ready; raise UsageError or ResultsError."""
    if os.path.lexists(folder / READY):
        with locked(folder), held():
            _move_in(folder)


def _commit(
    staging: Path, folder: Path, command: Mapping[str, Any], without: Collection[str]
) -> None:
    """Write the manifest and rename the staging folder, from which on it counts."""
    names = files_in(staging)
    manifest = Manifest(dict(command), {name: hash_of(staging / name) for name in names})
    with suppress(ResultsError):  # a folder without manifest
        older = Manifest.read(folder)
        gone = [name for name in older.sha256 if not (folder / name).exists()]
        manifest = older.followed_by(manifest, [*gone, *without])
    atomic_write(staging / MANIFEST, manifest.text())
    refuse_places(folder, MANIFEST)
    refuse_foreign(folder, {*names, *without})
    if not is_locked(folder):
        raise _removed(folder)
    staging.replace(folder / READY)
    sync_folder(folder)


def _move_in(folder: Path) -> None:
    ready = folder / READY
    try:
        refuse_places(folder, f"{READY}/{MANIFEST}")
        refuse_places(folder, MANIFEST)
        names = files_in(ready)
        refuse_foreign(folder, set(names) - {MANIFEST})
        places = {(folder / name).parent for name in names}
        for place in places:
            place.mkdir(parents=True, exist_ok=True)
        leaving: list[Path] = []
        with suppress(ResultsError):
            old, new = Manifest.read(folder), Manifest.read(ready)
            leaving = unchanged(folder, old, old.sha256.keys() - new.sha256.keys())
        for name in sorted(names, key=MANIFEST.__eq__):  # the manifest comes last
            if name == MANIFEST:
                for path in leaving:
                    path.unlink(missing_ok=True)
            (ready / name).replace(folder / name)
        for place in places:
            sync_folder(place)
        shutil.rmtree(ready)
        if not all((folder / name).exists() for name in names):
            raise _removed(folder)
    except OSError as error:
        raise ResultsError(
            f"{folder}: new results are complete but not all in place ({error.filename}: "
            f"{error.strerror}); correct that, and 'stickslip verify {folder}' moves the rest"
        ) from error


def _removed(folder: Path) -> ResultsError:
    return ResultsError(f"{folder}: was removed while results were written; run again")


def files_in(folder: Path) -> list[str]:
    """Return the names of all files below a folder, links to folders among them."""
    return sorted(
        path.relative_to(folder).as_posix()
        for path in folder.rglob("*")
        if path.is_symlink() or not path.is_dir()
    )


def remove_results(folder: Path) -> None:
    """Delete the unchanged files of the manifest, the manifest, and folders then empty."""
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
