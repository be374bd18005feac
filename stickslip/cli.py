"""The command ``stickslip``."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

from threadpoolctl import threadpool_limits

import cosim
import ga
import models
import toolchain
from cosim.control import ControlError
from stickslip.commands import (
    build,
    check,
    design,
    export,
    fleet,
    identify,
    learn,
    plan,
    reproduce,
    simulate,
    validate,
    verify,
)
from stickslip.errors import StickslipError

COMMANDS = (
    reproduce,
    build,
    simulate,
    check,
    design,
    plan,
    identify,
    learn,
    fleet,
    validate,
    verify,
    export,
)
EXPECTED = (
    StickslipError,
    cosim.CosimError,
    ControlError,
    ga.GaError,
    models.ModelError,
    toolchain.ToolchainError,
    OSError,
)
"""What a user can cause; everything else is a defect of ours and shows its traceback."""
_LONGEST = 2000  # characters of a message, which may hold what a stranger wrote


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return the exit status: 0, 1 for an error, 2 for usage, 130 for Ctrl-C."""
    options = _parser().parse_args(arguments)
    try:
        # One thread, so that results do not depend on how many the linear algebra would take.
        with threadpool_limits(limits=1, user_api="blas"):
            status = options.run(options)
        sys.stdout.flush()
    except BrokenPipeError:  # whoever read our output has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except EXPECTED as error:
        if options.debug:
            raise
        print(f"stickslip: {_line(error)}", file=sys.stderr)
        return 1
    except MemoryError:
        if options.debug:
            raise
        print("stickslip: more memory is needed than there is; give it less", file=sys.stderr)
        return 1
    except KeyboardInterrupt as interruption:
        print(f"stickslip: {interruption or 'interrupted'}", file=sys.stderr)
        return 130
    return status or 0


class _Parser(argparse.ArgumentParser):
    """A parser that complains in one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"stickslip: {message}; see '{self.prog} --help'\n")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="stickslip", description="Learn a friction compensator for a servo drive, in FMUs."
    )
    parser.add_argument("--debug", action="store_true", help="show the traceback of an error")
    subparsers = parser.add_subparsers(metavar="COMMAND", required=True)
    for command in COMMANDS:
        command.add_to(subparsers)
    _take_debug(subparsers)
    return parser


def _take_debug(subparsers: argparse._SubParsersAction[Any]) -> None:
    """Let ``--debug`` stand behind every command too."""
    for parser in subparsers.choices.values():
        parser.add_argument(
            "--debug", action="store_true", default=argparse.SUPPRESS, help=argparse.SUPPRESS
        )
        for action in parser._actions:  # noqa: SLF001 - argparse has no public way to them
            if isinstance(action.choices, dict):  # commands of its own
                _take_debug(action)


def _line(error: BaseException) -> str:
    """Return what an error says, in one line; only a compiler may say more."""
    if isinstance(error, toolchain.ToolchainError):
        return str(error)
    said = str(error)
    if isinstance(error, OSError) and error.filename:
        said = f"{error.filename}: {error.strerror}"
    line = " ".join(said.split()) or type(error).__name__
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in line[:_LONGEST])
