"""``--set NAME=VALUE``, ``--coarse NAME=FACTOR`` and ``--source`` on the command line."""

from __future__ import annotations

import math
from argparse import ArgumentParser
from collections.abc import Iterable, Sequence

from stickslip.catalog.parameters import LUGRE
from stickslip.commands import add_old_spelling
from stickslip.errors import UsageError

_WORDS = {"true": True, "on": True, "false": False, "off": False}


def add_set_option(parser: ArgumentParser, what: str) -> None:
    """Declare ``--set``, which can be repeated and takes several assignments."""
    parser.add_argument(
        "--set", nargs="+", action="extend", default=[], metavar="NAME=VALUE", help=what
    )


def add_coarse_option(parser: ArgumentParser) -> None:
    """Declare ``--coarse``, which can be repeated and takes several factors."""
    parser.add_argument(
        "--coarse",
        nargs="+",
        action="extend",
        default=[],
        metavar="NAME=FACTOR",
        help="start learning at these factors times the identified values, e.g. F_s=0.7 "
        "F_c=0.7 v_s=3 sigma_0=0.5 sigma_1=0.5; a parameter not named has the factor 1",
    )


def add_source_option(parser: ArgumentParser, sources: Sequence[str]) -> None:
    """Declare ``--source``, with which signal the compensator is driven; the first is usual."""
    action = parser.add_argument(
        "--source",
        dest="feed",
        choices=sources,
        default=sources[0],
        help="velocity input of the compensator: that of the nominal loop, or the command",
    )
    add_old_spelling(parser, "--feed", action)


def coarse_factors(texts: Iterable[str]) -> dict[str, float]:
    """Return factors on identified parameters by name.

    Raises
    ------
    UsageError
        When a name is none of LuGre's five, or a factor is not a positive finite number.
    """
    factors: dict[str, float] = {}
    for name, value in split_assignments(texts, "--coarse", "F_c=0.7").items():
        if name not in LUGRE:
            raise UsageError(f"--coarse {name}={value}: expected one of {', '.join(LUGRE)}")
        try:
            factors[name] = float(value)
        except ValueError:
            factors[name] = math.nan
        if not (math.isfinite(factors[name]) and factors[name] > 0.0):
            raise UsageError(
                f"--coarse {name}={value}: the factor must be a positive number, got '{value}'"
            )
    return factors


def split_assignments(
    texts: Iterable[str], option: str = "--set", example: str = "drive.F_c=6.5"
) -> dict[str, str]:
    """Return name -> value as it was written.

    Parameters
    ----------
    option, example : named in messages

    Raises
    ------
    UsageError
        When a text is no assignment, or a name comes twice.
    """
    values: dict[str, str] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise UsageError(f"{option} {text}: expected NAME=VALUE, such as {example}")
        if name in values:
            raise UsageError(f"{option} {text}: {name} is set twice")
        values[name] = value
    return values


def drive_changes(texts: Iterable[str]) -> dict[str, float | str]:
    """Return the assignments to ``drive.NAME`` without their prefix.

    All are numbers but ``law``, the name of the drive's friction law.

    Raises
    ------
    UsageError
        When another component is named, or a value is no number.
    """
    changes: dict[str, float | str] = {}
    for name, value in split_assignments(texts).items():
        if name == "drive.law":
            changes["law"] = value
            continue
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
