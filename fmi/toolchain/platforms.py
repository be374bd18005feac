"""The platforms an FMU can be built for, where built files lie, and the errors of the toolchain."""

import os
import platform as machine
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from stickslip.fmi.errors import Fault


class ToolchainError(Fault, RuntimeError):
    """Building a shared library from C sources failed."""


class CompilerMissing(ToolchainError):
    """Something has to be compiled, and the ``ziglang`` package, the compiler, is not installed."""


class CompilationFailed(ToolchainError):
    """The compiler rejected the sources. The message ends with its output."""


class CacheUnusable(ToolchainError):
    """The folder of built files, or the one for temporary files, cannot be written."""


class WrongExports(ToolchainError):
    """The library lacks a requested function, or exports one that was not requested."""


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


@dataclass(frozen=True)
class Platform:
    """One system on one processor; those of macOS share a universal library in FMI 2.0."""

    tuple: str  # platform tuple of FMI 3.0, section 2.5.1.4.1 (``x86_64-linux``)
    fmi2: str  # folder under ``binaries/`` in FMI 2.0 (``linux64``)
    target: str  # the compiler's target, with the oldest system it must run on
    suffix: str  # ending of a shared library


PLATFORMS = {
    p.tuple: p
    for p in (
        Platform("x86_64-linux", "linux64", "x86_64-linux-gnu.2.17", ".so"),
        Platform("aarch64-linux", "aarch64-linux", "aarch64-linux-gnu.2.17", ".so"),
        Platform("x86_64-windows", "win64", "x86_64-windows-gnu", ".dll"),
        Platform("x86_64-darwin", "darwin64", "x86_64-macos.10.13", ".dylib"),
        Platform("aarch64-darwin", "darwin64", "aarch64-macos.11.0", ".dylib"),
    )
}
_SYSTEMS = {"linux": "linux", "win32": "windows", "darwin": "darwin"}
_PROCESSORS = {"x86_64": "x86_64", "amd64": "x86_64", "aarch64": "aarch64", "arm64": "aarch64"}


def chosen_platforms(given: Iterable[Platform | str] | str | None) -> list[Platform]:
    """Return platforms, or those of names, ``host`` and ``all``, each once; the host for none.

    Raises ToolchainError for another name.
    """
    known = {**PLATFORMS, "host": None}
    found: list[Platform] = []
    for one in [given] if isinstance(given, str) else given or ["host"]:
        if one == "all":
            found += PLATFORMS.values()
        elif isinstance(one, Platform):
            found.append(one)
        elif one in known:
            found.append(known[one] or host_platform())
        else:
            raise ToolchainError(f"platforms: expected all or of {', '.join(known)}, got {one!r}")
    return list(dict.fromkeys(found))


def host_platform() -> Platform:
    """Return the platform this interpreter runs on; ToolchainError when it is not in PLATFORMS."""
    system = _SYSTEMS.get(sys.platform, sys.platform)
    processor = _PROCESSORS.get(machine.machine().lower(), machine.machine())
    try:
        return PLATFORMS[f"{processor}-{system}"]
    except KeyError:
        advice = f"FMUs run here on {', '.join(PLATFORMS)} only"
        raise ToolchainError(f"this machine is {processor}-{system}; {advice}") from None
