"""``--set NAME=VALUE`` on the command line."""

from __future__ import annotations

from argparse import ArgumentParser
from collections.abc import Iterable

from stickslip.errors import UsageError

_WORDS = {"true": True, "on": True, "false": False, "off": False}


def add_set_option(parser: ArgumentParser, what: str) -> None:
    """Declare ``--set``, which can be repeated and takes several assignments."""
    parser.add_argument(
        "--set", nargs="+", action="extend", default=[], metavar="NAME=VALUE", help=what
    )


def split_assignments(texts: Iterable[str]) -> dict[str, str]:
    """Return name -> value as it was written.

    Raises
    ------
    UsageError
        When a text is no assignment, or a name comes twice.
    """
    values: dict[str, str] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise UsageError(f"--set {text}: expected NAME=VALUE, such as drive.F_c=6.5")
        if name in values:
            raise UsageError(f"--set {text}: {name} is set twice")
        values[name] = value
    return values


def drive_changes(texts: Iterable[str]) -> dict[str, float]:
    """Return the assignments to ``drive.NAME`` without their prefix.

    Raises
    ------
    UsageError
        When another component is named, or a value is no number.
    """
    changes: dict[str, float] = {}
    for name, value in split_assignments(texts).items():
        if not name.startswith("drive."):
            raise UsageError(f"--set {name}: only the drive's parameters can be set, as drive.NAME")
        try:
            number = _WORDS[value.lower()] if value.lower() in _WORDS else float(value)
        except ValueError:
            raise UsageError(
                f"--set {name}={value}: the value must be a number, true or false, got '{value}'"
            ) from None
        changes[name.removeprefix("drive.")] = float(number)
    return changes
