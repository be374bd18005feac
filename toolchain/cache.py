"""Where built files lie, and how a file appears there whole or not at all."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from uuid import uuid4


def cache_directory() -> Path:
    """Return the folder of built files: ``$STICKSLIP_CACHE``, else the user's cache folder."""
    override = os.environ.get("STICKSLIP_CACHE")
    if override:
        return Path(override).expanduser().absolute()
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA", "~/AppData/Local")
    elif sys.platform == "darwin":
        base = "~/Library/Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return Path(base).expanduser() / "stickslip"


def write_whole(path: Path, content: bytes | str) -> Path:
    """Write a file so that a reader sees the old one or the new one, never a part of it.

    Text is written as UTF-8. The folder is made if it is absent.

    Raises
    ------
    OSError
        When the folder cannot be written or the disk is full; ``path`` is then as it was.
    """
    data = content.encode() if isinstance(content, str) else content
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{uuid4().hex}")
    try:
        with temporary.open("xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
    return path
