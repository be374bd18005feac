"""Where built files lie."""

from __future__ import annotations

import os
import sys
from pathlib import Path

CACHE_ADVICE = "set STICKSLIP_CACHE to a folder that can be written and has space"


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
