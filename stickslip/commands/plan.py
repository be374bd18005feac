"""``stickslip plan``: write the command of an experiment from which a drive can be learned.

stickslip plan --stroke 0.2 --speed 0.1 --out next.csv
stickslip plan --show sigma_0 sigma_1 --encoder 1e-6 --out next.csv
"""

from __future__ import annotations

import argparse
import io
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stickslip.commandline import FLAG, SEVERAL, add_options, positive, warn
from stickslip.commandline.assignments import split_assignments
from stickslip.errors import UsageError
from stickslip.fmi.files import atomic_write
from stickslip.logs.description import Description
from stickslip.logs.recording import Motion
from stickslip.logs.units import QUANTITIES, Unit, motion_of, parse_quantity, unit_named
from stickslip.output import Answer
from stickslip.planning import LINEAR, ROTARY, SET, Limits, Stretch, arrange, plan
from stickslip.planning.experiment import SHOWN
from stickslip.planning.shown import DataSheet, not_shown

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

_OPTIONS = {
    "stroke": ("position", "M", "distance between the two farthest positions"),
    "speed": ("velocity", "M/S", "highest speed"),
    "acceleration": ("acceleration", "M/S2", "highest acceleration"),
    "jerk": ("jerk", "M/S3", "highest jerk"),
    "duration": ("time", "S", "duration of the experiment"),
}
_KNOWN = {
    "friction": ("force", "N", "Coulomb friction, about"),
    "encoder": ("position", "M", "step of the encoder"),
}
"""What an option measures, its unit where none is given, and its help: limits, and what is known
of the drive beforehand."""


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.description = (
        "Write the velocity and position command of one experiment as CSV, in s, m/s and m (rotary "
        "rad/s and rad): small moves, creep with break-aways, constant speeds, quick ramps and a "
        "sine sweep. Run it on the drive, log time, force and position, and learn from the log. "
        "Limits may have units, such as 100mm, 40mm/s, 90deg, 300rpm or 5m/s3."
    )
    motion = {"--motion": "rotary: units with rad in place of m (default: from the units)"}
    add_options(parser, motion, choices=("linear", "rotary"))
    for name, (_, unit, text) in _OPTIONS.items():
        default = f"default {getattr(LINEAR, name):g}, rotary {getattr(ROTARY, name):g}"
        add_options(parser, {f"--{name} {unit}": f"{text} ({default})"})
    travel = "how far below and above the start the drive may go; one value for both"
    add_options(parser, {"--travel M": travel}, nargs="+")
    rate = {"--rate HZ": f"samples per second (default {LINEAR.rate:g})"}
    add_options(parser, rate, type=_rate)
    show = f"give more time to these parameters: {', '.join(SHOWN)} (gravity, cogging)"
    add_options(parser, {"--show PARAMETER": show}, **SEVERAL)
    group = parser.add_argument_group("the drive", "With these, it is printed what will not show.")
    for name, (_, unit, text) in _KNOWN.items():
        add_options(group, {f"--{name} {unit}": text})
    gain = {"--gain NAME=VALUE": "those of the controller, of which K_p and K_i count; SI units"}
    add_options(group, gain, **SEVERAL)
    out = {"--out FILE.csv": "file of the command (default plan.csv)"}
    add_options(parser, out, type=Path, default=Path("plan.csv"))
    whole = {
        "--set": "instead of one experiment, write one for each kind of motion, each of this "
        "duration, and runs.csv, the table that learns their logs together; --out is a folder"
    }
    add_options(parser, whole, **FLAG)
    add_options(parser, {"--plot FILE.png": "also draw the command"}, type=Path)
    add_options(parser, {"--force": "overwrite files that exist"}, **FLAG)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> Answer:
    """Write the command, and print when each part runs and how far it travels."""
    if options.set:
        return _write_set(options)
    for path, suffix in ((options.out, ".csv"), (options.plot, ".png")):
        if path and path.suffix.lower() != suffix:
            raise UsageError(f"{path}: expected a file name that ends in {suffix}")
        if path and path.is_file() and not path.is_symlink() and not options.force:
            raise UsageError(f"{path} exists; --force overwrites it, --out names another file")
    limits, length, sheet = _limits(options)
    table, stretches = plan(limits, options.show), arrange(limits, options.show)
    atomic_write(options.out, table.to_csv(index=False, float_format="%.12g", lineterminator="\n"))
    if options.plot:
        atomic_write(options.plot, _picture(table, stretches, length))
    _print_parts(table, stretches, length)
    _warn_of_speed(table, limits, length)
    missing = list(not_shown(sheet, limits, stretches, (length.name, length.factor)))
    print(*missing, sep="\n")
    written = [path for path in (options.out, options.plot) if path]
    print(*written, sep="\n")
    parts = [_part(table, one) for one in stretches]
    return Answer({"written": written, "parts": parts, "not_shown": missing})


def _write_set(options: argparse.Namespace) -> Answer:
    """Write an experiment for each kind of motion, and the table of the logs to be recorded."""
    folder = options.out.with_suffix("") if options.out.suffix == ".csv" else options.out
    if options.plot:
        raise UsageError("--plot draws one experiment; expected no --set with it")
    paths = {name: folder / f"{name}.csv" for name in SET}
    table = folder / "runs.csv"
    for path in (*paths.values(), table):
        if path.exists() and not options.force:
            raise UsageError(f"{path} exists; --force overwrites it, --out names another folder")
    limits, length, sheet = _limits(options)
    stretches: list[Stretch] = []
    folder.mkdir(parents=True, exist_ok=True)
    for name, among in SET.items():
        command, own = plan(limits, options.show, among), arrange(limits, options.show, among)
        text = command.to_csv(index=False, float_format="%.12g", lineterminator="\n")
        atomic_write(paths[name], text)
        print(f"{name}, {paths[name]}:")
        _print_parts(command, own, length)
        stretches += own
    missing = list(not_shown(sheet, limits, stretches, (length.name, length.factor)))
    rows = [f"{name}_log.csv,{name},," for name in SET]
    atomic_write(table, "\n".join(("log,kind,load,gains", *rows)) + "\n")
    print(*missing, sep="\n")
    print(f"record each, save its log under the name in {table}, and: stickslip learn {table}")
    return Answer({"written": [*paths.values(), table], "not_shown": missing})


def _rate(text: str) -> float:
    """Return a frequency [Hz], given as a number, in Hz or in kHz; or raise."""
    bare = text.strip().removesuffix("Hz")
    is_kilo = bare != text.strip() and bare.endswith("k")
    return positive(bare.removesuffix("k")) * 1e3 if is_kilo else positive(bare)


def _limits(options: argparse.Namespace) -> tuple[Limits, Unit, DataSheet]:
    """Return the limits, the unit of length in which they were given, and what is known."""
    values: dict[str, Any] = {}
    units: list[tuple[str, Unit]] = []

    def read(name: str, text: str, quantity: str) -> float:
        kinds = [kind[quantity] for kind in QUANTITIES.values() if quantity in kind]
        value, unit = parse_quantity(text, f"--{name}", kinds or [quantity])
        if unit:
            units.append((name, unit))
        return value

    known: dict[str, float] = {}
    for name, (quantity, *_) in (_OPTIONS | _KNOWN).items():
        if (text := getattr(options, name)) is not None:
            (values if name in _OPTIONS else known)[name] = read(name, text, quantity)
    for name, value in split_assignments(options.gain, "--gain", Description.GAINS).items():
        try:
            if name in ("K_p", "K_i"):  # those of the other parts tell nothing here
                known[name] = positive(value)
        except argparse.ArgumentTypeError as error:
            raise UsageError(f"--gain {name}: {error}") from None
    if options.travel:
        below, *above = (read("travel", text, "position") for text in options.travel[:2])
        if len(options.travel) > 2:
            raise UsageError(f"--travel: expected one or two values, got {len(options.travel)}")
        values["travel"] = (0.0 - below, *(above or [below]))
    if options.rate is not None:
        values["rate"] = options.rate
    linear: Motion = "linear"
    motions = [motion for _, unit in units if (motion := motion_of(unit))]
    chosen: Motion = options.motion or next(iter(motions), linear)
    for name, unit in units:
        if motion_of(unit) not in (None, chosen):
            raise UsageError(f"--{name} is in {unit.name}, but the motion is {chosen}")
    lengths = [
        unit_named(unit.name.split("/")[0])
        for name, unit in units
        if name in _OPTIONS or name == "travel"
    ]
    kind = QUANTITIES[chosen]["position"]
    given = [unit for unit in lengths if unit and unit.quantity == kind]
    fallback = Unit("rad", "angle", 1.0) if chosen == "rotary" else Unit("m", "length", 1.0)
    limits = replace(ROTARY if chosen == "rotary" else LINEAR, **values)
    if known.get("encoder", 0.0) > limits.stroke:
        what = f"--encoder {options.encoder}: expected one step, less than the stroke"
        raise UsageError(f"{what}; of n counts a turn it is 6.28319 / n rad")
    return limits, (*given, fallback)[0], DataSheet(**known)


def _part(table: pd.DataFrame, stretch: Stretch) -> dict[str, Any]:
    """Return what a stretch is, its times [s] and the parameters that it shows."""
    begin, end = table["time"].to_numpy()[[stretch.begin, stretch.end]]
    return {"begin": begin, "end": end, "name": stretch.part.name, "shows": stretch.part.shows}


def _print_parts(table: pd.DataFrame, stretches: tuple[Stretch, ...], length: Unit) -> None:
    _, v, x = (table[name].to_numpy() for name in table.columns)
    for stretch in stretches:
        part = _part(table, stretch)
        times = f"{part['begin']:7.2f} to {part['end']:6.2f} s"
        print(f"{times}  {part['name']:16} {' '.join(part['shows'])}")
    unit, per = length.name, 1.0 / length.factor
    print(f"speed up to {abs(v).max() * per:.3g} {unit}/s; ends at its start position")
    below, above = max(0.0, -x.min()) * per, x.max() * per
    print(f"travel: {below:.3g} {unit} below the start, {above:.3g} {unit} above")


def _warn_of_speed(table: pd.DataFrame, limits: Limits, length: Unit) -> None:
    """Warn when the speed that is asked for is not reached."""
    reached = float(table["velocity_command"].abs().max())
    if reached < 0.99 * limits.speed:
        unit, per = length.name, 1.0 / length.factor
        within = [f"a stroke of {limits.room * per:.4g} {unit}"]
        within.append(f"{limits.acceleration * per:.4g} {unit}/s^2")
        if limits.jerk < float("inf"):
            within.append(f"{limits.jerk * per:.4g} {unit}/s^3")
        warn(
            f"the speed {limits.speed * per:.4g} {unit}/s is not reached within "
            f"{', '.join(within)}: {reached * per:.4g} {unit}/s is"
        )


def _picture(table: pd.DataFrame, stretches: tuple[Stretch, ...], length: Unit) -> bytes:
    """Return a PNG file of a plan: velocity, position, and the first two parts enlarged."""
    from stickslip.presentation.style import PAGE, RESOLUTION, house_style, new_figure

    unit = "mm" if length.name == "m" else length.name
    large = 1e3 if length.name == "m" else 1 / length.factor
    small, fine = (1e6, "µm") if length.quantity == "length" else (1e3 * large, f"m{unit}")
    with house_style():
        figure = new_figure(PAGE, 125.0)
        grid = figure.add_gridspec(3, 2, height_ratios=(1.25, 1.0, 1.25))
        velocity = figure.add_subplot(grid[0, :])
        position = figure.add_subplot(grid[1, :], sharex=velocity)
        moves, slow = figure.add_subplot(grid[2, 0]), figure.add_subplot(grid[2, 1])
        _draw(velocity, table, "velocity_command", large, label=f"(a) velocity [{unit}/s]")
        _draw(position, table, "position_command", large, label=f"(b) position [{unit}]")
        _shade((velocity, position), table, stretches)
        first, second = (table[s.begin : s.end] for s in stretches[:2])
        _draw(moves, first, "position_command", small, label=f"(c) small moves [{fine}]")
        moves.set_yscale("symlog", linthresh=1.0)
        moves.set_ylim(bottom=0.0)
        _draw(slow, second, "velocity_command", large, label=f"(d) creep [{unit}/s]")
        for axes in (position, moves, slow):
            axes.set_xlabel("time [s]")
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=RESOLUTION, metadata={"Software": None})
    return stream.getvalue()


def _draw(axes: Axes, table: pd.DataFrame, column: str, scale: float, label: str) -> None:
    from stickslip.presentation.style import THIN, WITH

    axes.plot(table["time"], table[column] * scale, color=WITH, linewidth=THIN)
    axes.set(ylabel=label, xlim=(table["time"].iloc[0], table["time"].iloc[-1]))


def _shade(panels: tuple[Axes, Axes], table: pd.DataFrame, stretches: tuple[Stretch, ...]) -> None:
    """Shade every other part, and name all above the upper panel."""
    from stickslip.presentation.style import GREY, SHADE, SMALL

    ends = [*(s.begin for s in stretches), stretches[-1].end]
    times = table["time"].to_numpy()[ends]
    top = panels[0]
    for k, (begin, end) in enumerate(pairwise(times)):
        for axes in panels if k % 2 == 0 else ():
            axes.axvspan(begin, end, color=SHADE, linewidth=0)
        top.text(
            0.5 * (begin + end),
            1.03,
            stretches[k].part.name.replace(" ", "\n"),
            transform=top.get_xaxis_transform(),
            ha="center",
            va="bottom",
            color=GREY,
            fontsize=SMALL,
        )
