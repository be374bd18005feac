"""The option ``--platform``, for commands that build binaries."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from stickslip.errors import UsageError
from stickslip.fmi.toolchain import PLATFORMS, Platform, host_platform


def add_platform_option(parser: argparse.ArgumentParser) -> None:
    """Declare the option; ``parse_platforms`` reads its value."""
    parser.add_argument(
        "--platform",
        nargs="+",
        default=["host"],
        metavar="PLATFORM",
        help=f"host (default), all, or some of {', '.join(PLATFORMS)}",
    )


def parse_platforms(names: Sequence[str]) -> list[Platform]:
    """Return the platforms by name, each once.

    Raises
    ------
    UsageError
    """
    if list(names) == ["all"]:
        return list(PLATFORMS.values())
    platforms = {}
    for name in names:
        if name != "host" and name not in PLATFORMS:
            raise UsageError(
                f"--platform {name}: unknown; choose host, all or some of {', '.join(PLATFORMS)}"
            )
        platform = host_platform() if name == "host" else PLATFORMS[name]
        platforms[platform.tuple] = platform
    return list(platforms.values())
