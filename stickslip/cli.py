"""The command ``stickslip``."""

from __future__ import annotations

import argparse
import os
import re
import signal
import sys
from collections.abc import Iterable, Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import NamedTuple, NoReturn

from stickslip.errors import settings_as_options
from stickslip.fmi.errors import Fault
from stickslip.fmi.messages import harmless
from stickslip.fmi.process import (
    check_interruption,
    interrupted_by,
    interruptible,
    open_standard_streams,
)
from stickslip.output import answered, messages
from stickslip.parser import Parser, suffixes_of

_HELP = re.compile(r'"""``stickslip (\w+)``: ([^"]+?)\.?(?:""")?$')


_PLACES = ("commands/*.py", "studies/*/command.py", "papers/*/commands/*.py")


class Command(NamedTuple):
    """A command: the module that declares and runs it, imported when it is called, and its help."""

    module: str
    does: str


def _commands() -> dict[str, Command]:
    """Return the commands by name, from the first line of their modules."""
    found, root = {}, Path(__file__).parent
    for path in (path for place in _PLACES for path in root.glob(place)):
        with path.open(encoding="utf-8") as file:
            line = _HELP.match(file.readline().rstrip())
        if line:
            module = ".".join(("stickslip", *path.relative_to(root).with_suffix("").parts))
            found[line[1]] = Command(module, line[2])
    return dict(sorted(found.items()))


COMMANDS = _commands()
EXPECTED = (Fault, OSError, MemoryError)
"""Errors that a user can cause; any other is a defect and shows its traceback."""
_LONGEST = 2000  # characters of a message, which may contain text from a file


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return the exit status: 0, 1 for an error, 2 for usage, 130 for Ctrl-C.

    A SIGTERM or SIGHUP ends a command as Ctrl-C does, with 143 and 129.
    """
    if "_ARGCOMPLETE" in os.environ:  # a shell asks for completions
        _complete(os.environ["COMP_LINE"].split()[1:])
    open_standard_streams()  # those that cron or a service has closed
    given = list(sys.argv[1:] if arguments is None else arguments)
    plain = argparse.Namespace(json=False, quiet=False, verbose=False, debug=False)
    options = _parser(given).parse_args(given, plain)
    with interruptible(), messages(options), settings_as_options():
        try:
            return _status(options)
        except KeyboardInterrupt as interruption:
            with suppress(OSError):  # the terminal may be gone
                print(f"stickslip: {str(interruption) or 'interrupted'}", file=sys.stderr)
            try:
                sys.stdout.flush()
            except OSError:
                _drop_output()
            return 128 + (interrupted_by() or signal.SIGINT)


def _status(options: argparse.Namespace) -> int:
    try:
        status = answered(options, options.run)
        sys.stdout.flush()
    except BrokenPipeError:  # the reader of the output has ended
        _drop_output()
        return 1
    except Exception as error:
        check_interruption()  # which may be the cause
        if options.debug or not isinstance(error, EXPECTED):
            raise
        print(f"stickslip: {_line(error)}", file=sys.stderr)
        return 1
    return status


def _drop_output() -> None:
    """Discard later output, so that no error follows at the exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


class _Version(argparse.Action):
    """Prints the installed version, which takes time to find."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        from importlib.metadata import version  # late, for commands that start quickly

        print(f"stickslip {version('stickslip')}")
        parser.exit()


def _parser(arguments: Sequence[str]) -> argparse.ArgumentParser:
    parser = Parser(
        prog="stickslip", description="Learn a friction compensator for a servo drive, in FMUs."
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="show it and leave")
    subparsers = parser.add_subparsers(metavar="COMMAND", required=True)
    called = next((word for word in arguments if not word.startswith("-")), None)
    for name, (module, does) in COMMANDS.items():
        command = subparsers.add_parser(name, help=does)
        if name == called:
            import_module(module).declare(command)
    return parser


def _complete(words: Sequence[str]) -> None:
    """Answer the shell and exit: commands, options, choices, and files where one is expected."""
    from argcomplete import autocomplete
    from argcomplete.completers import BaseCompleter, FilesCompleter

    class Files(BaseCompleter):
        def __call__(self, *, prefix: str, action: argparse.Action, **_: object) -> Iterable[str]:
            suffixes = suffixes_of(action)
            return FilesCompleter(suffixes)(prefix) if suffixes or action.type is Path else ()

    autocomplete(_parser(words), "long", exclude=["FILE.ssp"], default_completer=Files())


def _line(error: BaseException) -> str:
    """Return the message of an error in one line; only that of a compiler has more lines."""
    from stickslip.fmi.toolchain import ToolchainError  # late, for those who start quickly

    message = str(error)
    if isinstance(error, ToolchainError):
        return message
    if isinstance(error, MemoryError):
        message = "not enough memory; reduce the size of the input"
    if isinstance(error, OSError) and error.filename:
        message = f"{error.filename}: {error.strerror}"
    return harmless((" ".join(message.split()) or type(error).__name__)[:_LONGEST])
