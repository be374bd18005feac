"""``--isolate``: FMUs from outside in a process of their own, wherever a command runs some.

That is the default where it is tested, on Linux: nobody knows what a stranger's FMU does.
"""

from __future__ import annotations

import argparse
import sys

from stickslip import cosim
from stickslip.errors import UsageError


def add_isolation(parser: argparse.ArgumentParser) -> None:
    """Declare ``--isolate`` and its limits."""
    parser.add_argument(
        "--isolate",
        action=argparse.BooleanOptionalAction,
        default=sys.platform == "linux",
        help="run the FMUs in a child process, so that a crash does not end the command (default "
        "on Linux)",
    )
    parser.add_argument(
        "--timeout",
        type=float,
        metavar="S",
        help="with isolation: time limit of the run (default: 30 s for each step)",
    )
    parser.add_argument(
        "--memory",
        type=float,
        metavar="MB",
        help="with isolation: memory limit (Linux, default 4096)",
    )


def isolation_of(options: argparse.Namespace) -> cosim.Isolation | None:
    """Return what the options ask for.

    Raises
    ------
    UsageError
        When there is a limit for nothing.
    """
    given = {"timeout": options.timeout, "memory": options.memory}
    limits = {name: value for name, value in given.items() if value is not None}
    if limits and not options.isolate:
        raise UsageError(f"--{next(iter(limits))} needs --isolate, which it limits")
    return cosim.Isolation(**limits) if options.isolate else None
