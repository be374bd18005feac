"""Options that describe a log, for the commands that read one."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from stickslip.commandline import SEVERAL, add_options, add_rare_group, require_files
from stickslip.commandline.assignments import split_assignments
from stickslip.errors import UsageError
from stickslip.logs import Column, Description, load_description
from stickslip.logs.description import CONFIRMED, GAINS, ROLES, Kind
from stickslip.logs.units import parse_quantity
from stickslip.planning import LINEAR, Limits

if TYPE_CHECKING:
    from stickslip.rigs.contract import Rig

MOTIONS = "motions"  # Folder, within that of the results, of the logs of a rig


def add_rig_option(parser: argparse._ActionsContainer, what: str) -> None:
    """Declare ``--rig``."""
    text = f"{what}; --out keeps its logs, and the same command goes on there (docs/rig.md)"
    add_options(parser, {"--rig FILE.toml": text}, type=Path)


@contextmanager
def rig_of(path: Path | None, out: Path | None, law: str) -> Iterator[tuple[Rig | None, Limits]]:
    """Return the rig of a file, whose logs are kept in a folder of results, and its experiment."""
    if path is None:
        yield None, LINEAR
        return
    from stickslip.rigs.file import KeptRig, open_rig

    rig, limits = open_rig(path, "lugre" if law == "auto" else law)
    with rig:
        yield (KeptRig(rig, out / MOTIONS) if out else rig), limits


_PARTS = {"column": "name", "unit": "unit", "scale": "scale", "offset": "offset"}
"""Options of several ROLE=VALUE, and the attribute of a column that each one sets."""
_SINGLE = (
    *("motion", "encoder_step", "force_limit", "delimiter", "decimal"),
    *("sample_period", "tau_i", "rated_force", "rated_torque"),
)
_QUANTITIES = {
    "encoder_step": ("length", "angle"),
    "force_limit": ("force", "torque"),
    "rated_force": ("force",),
    "rated_torque": ("torque",),
}
"""What single options measure that take a number with a unit, besides a product."""


def add_log_argument(parser: argparse.ArgumentParser, *, several: bool = False) -> None:
    """Declare the log's file as an argument, and ``--log`` as another spelling of it."""
    files = "CSV, Excel, Parquet, MAT, HDF5, TDMS or MF4"
    parser.add_argument(
        "log",
        nargs="*" if several else "?",
        type=Path,
        metavar="LOG",
        help=f"{files}; several logs of one drive, folders of them, or a table of them with the "
        "columns log, load, gains, config and use"
        if several
        else files,
    )
    parser.add_argument("--log", dest="log_option", type=Path, help=argparse.SUPPRESS)


def logs_given(options: argparse.Namespace) -> list[Path]:
    """Return the files and folders of one log or several; raise what ``log_of`` does."""
    if len(options.log) < 2:
        return [one_of("a log", *options.log, options.log_option, folder=True)]
    require_files(*(path for path in options.log if not path.is_dir()))
    return list(options.log)


def log_of(options: argparse.Namespace) -> Path:
    """Return the log's file; raise UsageError when none, or two, are given."""
    return one_of("a log", options.log, options.log_option)


def one_of(what: str, *given: Path | None, folder: bool = False) -> Path:
    """Return the one path that is given; raise UsageError when it is not one, or OSError."""
    paths = [path for path in given if path is not None]
    if len(paths) != 1:
        got = " and ".join(map(str, paths)) or "none"
        raise UsageError(f"expected {what} as an argument; got {got}")
    if not (folder and paths[0].is_dir()):
        require_files(paths[0])
    return paths[0]


def add_log_options(parser: argparse.ArgumentParser) -> argparse._ArgumentGroup:
    """Declare what describes a log, options before a TOML file; return the controller's group."""
    group = parser.add_argument_group(
        "the log",
        f"ROLE is one of {', '.join(ROLES)}. Options override the file given by --config.",
    )
    add_options(group, {"--config FILE.toml": "describes the log"}, type=Path)
    several = {
        "--column ROLE=NAME": "name of a column, its number from 1, or none",
        "--unit ROLE=UNIT": "such as position=mm or force=A",
    }
    add_options(group, several, **SEVERAL)
    add_options(group, {"--motion": "(default: from the units)"}, choices=("linear", "rotary"))
    span = {"--span": "part of the log to use [s]"}
    add_options(group, span, nargs=2, type=float, metavar=("BEGIN", "END"))

    loop = parser.add_argument_group("the controller of the log")
    controller = {"--controller": "controller of the drive (default none: not known)"}
    add_options(loop, controller, choices=get_args(Kind))
    gains = {"--gain NAME=VALUE": f"gains of the controller: {', '.join(GAINS)}; SI units"}
    add_options(loop, gains, **SEVERAL)
    add_options(loop, {"--force-limit N": "of motor or amplifier, such as 205 or 0.2kN"})

    group = add_rare_group(parser, "units of the log")
    several = {
        "--scale ROLE=NUMBER": "SI units per unit, such as force=23 for N per A (also of mA)",
        "--offset ROLE=NUMBER": "offset added to the value, in SI units",
        "--confirm FIGURE": f"{', '.join(CONFIRMED)}: the extreme value and its units are correct",
    }
    add_options(group, several, **SEVERAL)
    rated = {
        "--rated-force N": "what 100 %% of the rated force or current are",
        "--rated-torque N.m": "what 100 %% of the rated torque or current are, such as 2.4Nm",
    }
    add_options(group, rated)

    group = add_rare_group(parser, "file and sampling of the log")
    step = "resolution of the position, such as 4e-7 or 0.4um (default: detected)"
    delimiter = {"--delimiter CHAR": "delimiter of a text file (default: detected)"}
    add_options(group, {"--encoder-step M": step, **delimiter})
    decimal = {"--decimal": "decimal sign of a text file (default: detected)"}
    add_options(group, decimal, choices=(".", ","))
    numbers = {
        "--sample-period S": "sample period, in place of a column of time",
        "--tau-i S": "time constant of the current loop",
    }
    add_options(group, numbers, type=float)
    return loop


def description_of(options: argparse.Namespace) -> Description:
    """Return the description that options and their file give together."""
    base = load_description(options.config) if options.config else Description()
    columns = dict(base.columns)
    for option, part in _PARTS.items():
        texts = getattr(options, option)
        for role, value in split_assignments(texts, f"--{option}", ROLES).items():
            columns[role] = replace(columns.get(role, Column()), **{part: value})
    changes: dict[str, Any] = {"columns": columns}
    gains = split_assignments(options.gain, "--gain", GAINS)
    if options.controller and options.controller != base.controller:
        changes["controller"], changes["gains"] = options.controller, gains
    else:
        changes["gains"] = {**base.gains, **gains}
    for name in _SINGLE:
        if (value := getattr(options, name)) is not None:
            changes[name] = "\t" if value == "\\t" else _number_with_unit(name, value)
    if options.confirm:
        changes["confirm"] = (*base.confirm, *options.confirm)
    if options.span:
        changes["span"] = tuple(options.span)
    return replace(base, **changes)


def _number_with_unit(name: str, value: Any) -> Any:
    """Return a number with a unit in SI units, anything else as it is."""
    if name not in _QUANTITIES or not re.fullmatch(r"[-+.\d][^*]*[^\d\s.]", value):
        return value  # a number, or a product
    return parse_quantity(value, f"--{name.replace('_', '-')}", _QUANTITIES[name])[0]
