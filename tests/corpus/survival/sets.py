"""Sets of results, how they are written, and whether a folder holds one of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from stickslip.fmi.files import atomic_write
from stickslip.results.folder import locked, staged, verify

Files = Mapping[str, bytes]

OLD: Files = {
    "table.csv": b"old\n" * 2000,
    "learned.json": b"{}\n",
    "only_old.png": b"\x89PNG" * 9,
    "drives/a/learned.json": b'{"a": 1}\n',
}
NEW: Files = {
    "table.csv": b"new\n" * 3000,
    "learned.json": b'{"m": 5.5}\n',
    "only_new.svg": b"<svg/>",
    "drives/a/learned.json": b'{"a": 2}\n',
    "drives/b/learned.json": b'{"b": 2}\n',
}


def write(files: Files, folder: Path) -> None:
    """Write a set as commands do."""
    with staged(folder, {"name": "survival"}) as staging:
        for name, content in files.items():
            atomic_write(staging / name, content)


def plain(folder: Path) -> Files:
    """Return what a reader sees who knows of no hidden files and no manifest."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
        and not path.relative_to(folder).as_posix().startswith(".stickslip-")
        and path.name != "manifest.json"
    }


def holds(folder: Path, sets: Iterable[Files]) -> str:
    """Return ``at once`` or ``recovered`` for a folder that holds one of the sets.

    Raises
    ------
    RuntimeError
        When it holds none of them, or not as its manifest says, or something else is left.
    """
    sets = list(sets)
    found = "at once" if plain(folder) in sets else "recovered"
    verdict = verify(folder)
    if verdict.faults or plain(folder) not in sets:
        raise RuntimeError(f"{folder} holds neither set: {verdict}, {sorted(plain(folder))}")
    with locked(folder):
        pass
    if left := [path.name for path in folder.glob(".stickslip-*")]:
        raise RuntimeError(f"{folder}: left behind: {left}")
    return found
