"""``--isolate``: FMUs from outside in a process of their own, wherever a command runs some."""

from __future__ import annotations

import argparse

import cosim
from stickslip.errors import UsageError


def add_isolation(parser: argparse.ArgumentParser) -> None:
    """Declare ``--isolate`` and its limits."""
    parser.add_argument(
        "--isolate",
        action="store_true",
        help="run the FMUs in a process of their own, which they may crash",
    )
    parser.add_argument(
        "--timeout",
        type=float,
        metavar="S",
        help="with --isolate: the run may take; 30 s for each step by default",
    )
    parser.add_argument(
        "--memory", type=float, metavar="MB", help="with --isolate: 4096 by default (Linux)"
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
