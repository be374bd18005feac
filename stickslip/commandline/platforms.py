"""The options of an FMU that is written: ``--platform``, ``--fmi`` and ``--out``."""

import argparse
from pathlib import Path
from typing import Any

from stickslip.fmi.toolchain import PLATFORMS


def add_platform_option(parser: argparse.ArgumentParser, default: str = "all") -> None:
    """Declare the option."""
    parser.add_argument(
        "--platform",
        nargs="+",
        default=[default],
        choices=["host", "all", *PLATFORMS],
        metavar="PLATFORM",
        help=f"host, all, or some of {', '.join(PLATFORMS)} (default {default})",
    )


def add_fmu_options(
    parser: argparse.ArgumentParser, *, platform: str = "all", out: str = "DIR"
) -> None:
    """Declare version, platforms (with their default) and place of one FMU."""
    parser.add_argument("--fmi", choices=["2", "3"], default="2", help="version of the standard")
    add_platform_option(parser, platform)
    parser.add_argument("--out", type=Path, default=Path(), metavar=out)


def fmu_options(options: argparse.Namespace) -> dict[str, Any]:
    """Return version and platforms as the functions that write FMUs take them."""
    return {"fmi": int(options.fmi), "platforms": options.platform}
