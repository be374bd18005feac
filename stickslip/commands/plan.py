"""``stickslip plan``: write the command of an experiment from which a drive can be learned."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import pandas as pd

from stickslip.catalog.parameters import PAPER
from stickslip.commands import SEVERAL, add_options
from stickslip.errors import UsageError
from stickslip.fmi.files import atomic_write
from stickslip.planning import LINEAR, ROTARY, Stretch, arrange, draw_plan, plan

_OPTIONS = {
    "stroke": ("M", "distance between the two farthest positions"),
    "speed": ("M/S", "highest speed"),
    "acceleration": ("M/S2", "highest acceleration"),
    "duration": ("S", "duration of the experiment"),
    "rate": ("HZ", "samples per second"),
}


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.description = (
        "Write the velocity and position command of one experiment as CSV: small "
        "moves, slow reversals, constant speeds, quick ramps and a sine sweep. Run it on the "
        "drive, log time, force and position, and learn from the log."
    )
    motion = {"--motion": "rotary: units with rad in place of m"}
    add_options(parser, motion, choices=("linear", "rotary"), default="linear")
    for name, (unit, text) in _OPTIONS.items():
        default = f"default {getattr(LINEAR, name):g}, rotary {getattr(ROTARY, name):g}"
        add_options(parser, {f"--{name} {unit}": f"{text} ({default})"}, type=float)
    show = f"give more time to these parameters: {', '.join(PAPER)}"
    add_options(parser, {"--show PARAMETER": show}, **SEVERAL)
    out = {"--out FILE.csv": "file of the command (default plan.csv)"}
    add_options(parser, out, type=Path, default=Path("plan.csv"))
    add_options(parser, {"--plot FILE.png": "also draw the command"}, type=Path)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Write the command, and print when each part runs and how far it travels."""
    for path, suffix in ((options.out, ".csv"), (options.plot, ".png")):
        if path and path.suffix.lower() != suffix:
            raise UsageError(f"{path}: expected a file name that ends in {suffix}")
    given = {name: getattr(options, name) for name in _OPTIONS}
    limits = replace(
        ROTARY if options.motion == "rotary" else LINEAR,
        **{name: value for name, value in given.items() if value is not None},
    )
    table, stretches = plan(limits, options.show), arrange(limits, options.show)
    atomic_write(options.out, table.to_csv(index=False, float_format="%.12g", lineterminator="\n"))
    if options.plot:
        atomic_write(options.plot, draw_plan(table, stretches, options.motion))
    _print_parts(table, stretches, "rad" if options.motion == "rotary" else "m")
    print(options.out)
    if options.plot:
        print(options.plot)


def _print_parts(table: pd.DataFrame, stretches: tuple[Stretch, ...], unit: str) -> None:
    time, v, x = (table[name].to_numpy() for name in table.columns)
    for stretch in stretches:
        begin, end = time[stretch.begin], time[stretch.end]
        shows = " ".join(stretch.part.shows)
        print(f"{begin:7.2f} to {end:6.2f} s  {stretch.part.name:16} {shows}")
    print(f"speed up to {abs(v).max():.3g} {unit}/s; ends at its start position")
    print(f"travel: {max(0.0, -x.min()):.3g} {unit} below the start, {x.max():.3g} {unit} above")
