"""Options that describe a log, for the commands that read one."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

from stickslip.errors import UsageError
from stickslip.fmi.messages import suggestion
from stickslip.logs import ROLES, Column, Description, Kind, load_description
from stickslip.logs.controller import GAINS
from stickslip.logs.description import CONFIRMED

_PARTS = {"column": "name", "unit": "unit", "scale": "scale", "offset": "offset"}
"""Options of several ROLE=VALUE, and what of a column they say."""


def add_log_options(parser: argparse.ArgumentParser) -> None:
    """Declare what describes a log: a TOML file, or options that go before it."""
    group = parser.add_argument_group(
        "the log",
        f"ROLE is one of {', '.join(ROLES)}. Options override the file given by --config.",
    )
    group.add_argument("--config", type=Path, metavar="FILE.toml", help="describes the log")
    texts = {
        "column": ("ROLE=NAME", "name of a column, its number from 1, or none"),
        "unit": ("ROLE=UNIT", "such as position=mm or force=A"),
        "scale": ("ROLE=NUMBER", "SI units per unit, such as force=23 for N per A (also of mA)"),
        "offset": ("ROLE=NUMBER", "offset added to the value, in SI units"),
    }
    for name, (metavar, text) in texts.items():
        _add_several(group, f"--{name}", metavar, text)
    group.add_argument("--motion", choices=("linear", "rotary"), help="(default: from the units)")
    group.add_argument(
        "--controller",
        choices=get_args(Kind),
        help="controller of the drive (default none: not known)",
    )
    _add_several(
        group, "--gain", "NAME=VALUE", f"gains of the controller: {', '.join(GAINS)}; SI units"
    )
    for name, metavar, text in (
        ("encoder-step", "M", "resolution of the position (default: detected)"),
        ("force-limit", "N", "force limit of motor or amplifier"),
    ):
        group.add_argument(f"--{name}", metavar=metavar, help=text)
    group.add_argument(
        "--sample-period",
        type=float,
        metavar="S",
        help="sample period, in place of a column of time",
    )
    group.add_argument("--tau-i", type=float, metavar="S", help="time constant of the current loop")
    group.add_argument(
        "--span", nargs=2, type=float, metavar=("BEGIN", "END"), help="part of the log to use [s]"
    )
    group.add_argument(
        "--confirm",
        nargs="+",
        action="extend",
        default=[],
        metavar="FIGURE",
        help=f"{', '.join(CONFIRMED)}: the extreme value and its units are correct",
    )
    group.add_argument("--delimiter", metavar="CHAR", help="of a text file (default: found out)")
    group.add_argument("--decimal", choices=(".", ","), help="of a text file (default: found out)")


def description_of(options: argparse.Namespace) -> Description:
    """Return the description that options and their file give together.

    Raises
    ------
    UsageError
        When an option or the file says what cannot be.
    """
    base = load_description(options.config) if options.config else Description()
    columns = dict(base.columns)
    for option, part in _PARTS.items():
        for role, value in _pairs(f"--{option}", getattr(options, option), ROLES).items():
            columns[role] = replace(columns.get(role, Column()), **{part: value})
    changes: dict[str, Any] = {"columns": columns}
    gains = _pairs("--gain", options.gain, GAINS)
    if options.controller and options.controller != base.controller:
        changes["controller"], changes["gains"] = options.controller, gains
    else:
        changes["gains"] = {**base.gains, **gains}
    for name in (
        "motion",
        "encoder_step",
        "force_limit",
        "sample_period",
        "tau_i",
        "delimiter",
        "decimal",
    ):
        if (value := getattr(options, name)) is not None:
            changes[name] = {"\\t": "\t"}.get(value, value)
    if options.confirm:
        changes["confirm"] = (*base.confirm, *options.confirm)
    if options.span:
        changes["span"] = tuple(options.span)
    return replace(base, **changes)


def _add_several(group: argparse._ArgumentGroup, option: str, metavar: str, text: str) -> None:
    group.add_argument(option, nargs="+", action="extend", default=[], metavar=metavar, help=text)


def _pairs(option: str, texts: Iterable[str], known: tuple[str, ...]) -> dict[str, str]:
    """Return name -> value of ``NAME=VALUE``; the value may hold = itself."""
    values: dict[str, str] = {}
    for text in texts:
        name, _, value = (part.strip() for part in text.partition("="))
        if not (name and value):
            raise UsageError(f"{option} {text}: expected NAME=VALUE")
        if name not in known:
            raise UsageError(f"{option} {text}: no '{name}'{suggestion(name, known)}")
        if name in values:
            raise UsageError(f"{option} {text}: {name} is set twice")
        values[name] = value
    return values
