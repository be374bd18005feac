"""Libraries that come with a wheel, so that it runs without a compiler: ``compiled.zip``.

A member is called RECIPE/FILE; the comment of the archive is the version of the compiler.
"""

from __future__ import annotations

import zipfile
from functools import cache
from pathlib import Path

ARCHIVE = Path(__file__).with_name("compiled.zip")


@cache
def _content(archive: Path) -> tuple[str, frozenset[str]]:
    """Return the version of the compiler, and the names of the members."""
    if not archive.exists():
        return "", frozenset()
    with zipfile.ZipFile(archive) as opened:
        return opened.comment.decode(), frozenset(opened.namelist())


def shipped_compiler(member: str) -> str | None:
    """Return the version of the compiler that a library is from; None if it is not there."""
    compiler, members = _content(ARCHIVE)
    return compiler if member in members else None


def shipped_library(member: str) -> bytes | None:
    """Return the bytes of a library; None if it is not there."""
    if shipped_compiler(member) is None:
        return None
    with zipfile.ZipFile(ARCHIVE) as opened:
        return opened.read(member)
