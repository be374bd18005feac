"""``--isolate``: FMUs in a process of their own; the default where it is tested, on Linux."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from stickslip.commands import add_options
from stickslip.errors import UsageError

if TYPE_CHECKING:
    from stickslip import cosim


def add_isolation(parser: argparse.ArgumentParser) -> None:
    """Declare ``--isolate`` and its limits."""
    parser.add_argument(
        "--isolate",
        action=argparse.BooleanOptionalAction,
        default=sys.platform == "linux",
        help="run the FMUs in a child process, so that a crash does not end the command (default "
        "on Linux)",
    )
    limits = {
        "--timeout S": "with isolation: time limit of the run (default: 30 s for each step)",
        "--memory MB": "with isolation: memory limit (Linux, default 4096)",
    }
    add_options(parser, limits, type=float)


def isolation_of(options: argparse.Namespace) -> cosim.Isolation | None:
    """Return what the options ask for.

    Raises
    ------
    UsageError
        When a limit is given without isolation.
    """
    from stickslip import cosim

    given = {"timeout": options.timeout, "memory": options.memory}
    limits = {name: value for name, value in given.items() if value is not None}
    if limits and not options.isolate:
        raise UsageError(f"--{next(iter(limits))} needs --isolate, which it limits")
    return cosim.Isolation(**limits) if options.isolate else None
