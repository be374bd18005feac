"""What commands share: how options are declared, progress on a terminal, options of logs and rigs.

A command is a file: ``declare`` declares its options, ``run`` executes it. Its first line,
``stickslip NAME`` and what it does, makes it a command. Lines of the same text that begin with
``stickslip`` are the examples of its help.
"""

import argparse
import math
import re
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from stickslip.output import LOG, Answer

SEVERAL: dict[str, Any] = {"nargs": "+", "action": "extend", "default": []}
"""An option that takes several values and can be repeated."""
_RARE = " (rarely needed)"
FLAG = {"action": "store_true"}


def add_options(
    parser: argparse._ActionsContainer, texts: Mapping[str, str], **settings: Any
) -> None:
    """Declare options that share their settings; ``texts`` is ``--name METAVAR`` -> help."""
    if choices := settings.get("choices"):
        settings.setdefault("type", partial(_in_any_case, choices))
    for option, text in texts.items():
        name, _, metavar = option.partition(" ")
        shown: dict[str, Any] = {"metavar": metavar} if metavar else {}
        parser.add_argument(name, help=text, **shown, **settings)


def _in_any_case(choices: Iterable[str], text: str) -> str:
    """Return the choice that a text is but for upper and lower case, or the text."""
    return next((one for one in choices if one.casefold() == text.casefold()), text)


def add_rare_group(parser: argparse.ArgumentParser, title: str) -> argparse._ArgumentGroup:
    """Return a group of options that ``--help-all`` lists, but not ``--help``."""
    return parser.add_argument_group(f"{title}{_RARE}")


def is_rare(group: argparse._ArgumentGroup) -> bool:
    """Tell whether a group is one of these."""
    return (group.title or "").endswith(_RARE)


def at_least(least: int) -> Callable[[str], int]:
    """Return the type of an option that is a whole number, for ``argparse``."""

    def whole_number(text: str) -> int:
        if not re.fullmatch(r"[+-]?\d+", text) or (value := int(text)) < least:
            raise argparse.ArgumentTypeError(
                f"expected a whole number, at least {least}, got {text!r}"
            )
        return value

    return whole_number


def positive(text: str) -> float:
    """Return a positive finite number of the command line."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"expected a positive number, got {text!r}")
    return value


def seconds(text: str) -> float:
    """Return a time limit [s], a type for ``argparse``."""
    value = float(text)
    if not value > 0.0:
        raise argparse.ArgumentTypeError(f"expected a number of seconds above 0, got {text!r}")
    return value


def require_files(*paths: Path | None) -> None:
    """Raise OSError where a file or folder that is given is not there, before heavy imports."""
    for path in paths:
        if path is not None:
            path.stat()


def complete_with(action: argparse.Action, names: Callable[[], Iterable[str]]) -> None:
    """Let a shell complete the values of an argument that is not limited to them."""
    action.completer = lambda **_: names()  # type: ignore[attr-defined]


def warn(message: str) -> None:
    """Print a warning to standard error, unless with ``--quiet``."""
    LOG.warning("%s", message)


def or_(names: Iterable[str]) -> str:
    """Return names as ``a, b or c``."""
    *most, last = names
    return f"{', '.join(most)} or {last}" if most else last


def written(*paths: Path) -> Answer:
    """Print the paths of files that were written; return the answer of the command."""
    print(*paths, sep="\n")
    return Answer({"written": [*paths]})


def write_files(out: Path | None, command: Mapping[str, object], files: Mapping[str, str]) -> None:
    """Write texts by file name into a folder of results, if there is one, and print their paths."""
    from stickslip.fmi.files import atomic_write  # late: they load more than the command line needs
    from stickslip.storage import staged

    if out is None:
        return
    with staged(out, command) as staging:
        for name, text in files.items():
            atomic_write(staging / name, text)
    print(*(out / name for name in files), sep="\n")
