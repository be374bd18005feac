"""``--isolate``: FMUs in a process of their own; the default for those of others, on Linux."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING, Any

from stickslip.commandline import add_options
from stickslip.errors import UsageError

if TYPE_CHECKING:
    from stickslip import cosim


def add_isolation(parser: argparse.ArgumentParser) -> None:
    """Declare ``--isolate`` and its limits."""
    parser.add_argument(
        "--isolate",
        action=argparse.BooleanOptionalAction,
        help="run the FMUs in a child process, so that a crash does not end the command (default "
        "on Linux, unless this installation compiled all of them)",
    )
    limits = {
        "--timeout S": "with isolation: time limit of the run (default: 30 s for each step)",
        "--memory MB": "with isolation: memory limit (Linux, default 4096)",
    }
    add_options(parser, limits, type=float)
    allow = {
        "--allow network|exec|files=DIR|env=NAME": "with isolation: what the sandbox lets the FMUs "
        "do; may be repeated (Linux)"
    }
    add_options(parser, allow, action="append")


def isolation_of(options: argparse.Namespace) -> cosim.Isolated:
    """Return what the options ask for; raise UsageError when a limit is given without isolation."""
    from stickslip import cosim

    given = {"timeout": options.timeout, "memory": options.memory}
    limits: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    if options.allow:
        limits["allow"] = tuple(options.allow)
    limited = options.isolate or (options.isolate is None and sys.platform == "linux")
    if limits and not limited:
        raise UsageError(f"--{next(iter(limits))} needs --isolate, which it limits")
    if limits or options.isolate:
        return cosim.Isolation(**limits)
    return "foreign" if options.isolate is None else None
