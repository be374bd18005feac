"""The libraries of an FMU for several platforms, by their place in it."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable
from pathlib import Path

from stickslip.fmi.binary import universal
from stickslip.fmi.process.threads import Threads
from stickslip.fmi.toolchain.compiler import vouch
from stickslip.fmi.toolchain.platforms import Platform


def standard_functions(header: str) -> list[str]:
    """Return what every FMU of a standard exports, as its ``fmi?Functions.h`` says."""
    return re.findall(r"^ *FMI._Export +\w+ +(\w+);", header, re.MULTILINE)


def binaries(
    name: str,
    fmi: int,
    platforms: Iterable[Platform],
    build: Callable[[Platform], Path],
    change: Callable[[bytes], bytes] | None = None,
) -> dict[str, bytes]:
    """Build for all platforms side by side; return path in the FMU -> library.

    Platforms that share a folder in FMI 2.0 share a universal library.

    Parameters
    ----------
    name : what the libraries are called in the FMU, without ending
    fmi : version of the standard, which names the folders
    build : returns the library of a platform
    change : returns what becomes of the content of a library; nothing by default
    """
    targets = list(platforms)
    parts: dict[str, list[bytes]] = {}
    with Threads(os.cpu_count()) as pool:
        for platform, library in zip(targets, pool.each(build, targets), strict=True):
            folder = platform.fmi2 if fmi == 2 else platform.tuple
            content = library.read_bytes()
            if change is not None:
                content = change(content)
                vouch(content)
            parts.setdefault(f"binaries/{folder}/{name}{platform.suffix}", []).append(content)
    return {path: universal(libraries) for path, libraries in parts.items()}
