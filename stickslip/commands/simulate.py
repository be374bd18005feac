"""``stickslip simulate``: run a system of FMUs (.ssp) or one FMU."""

from __future__ import annotations

import argparse
from contextlib import nullcontext
from pathlib import Path

from stickslip import cosim
from stickslip.commands import FLAG, SEVERAL, add_options
from stickslip.commands.assignments import add_set_option, split_assignments
from stickslip.commands.isolation import add_isolation, isolation_of
from stickslip.errors import UsageError
from stickslip.fmi.files import require_regular_file
from stickslip.results.folder import writable
from stickslip.simulation import Model


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("file", type=Path, metavar="FILE.ssp|FILE.fmu")
    numbers = {
        "--stop S": "stop time, instead of that of the file",
        "--step S": "communication step, instead of that of the file; 1/500 of the run for an FMU "
        "that proposes none",
        "--tolerance REL": "relative tolerance of the solvers, instead of that of the FMUs",
        "--until S": "halt at this time, before the stop",
        "--real-time FACTOR": "simulated seconds per second (default: full speed)",
        "--look S": "simulated seconds between two looks at the clock (default: 0.01)",
    }
    add_options(parser, numbers, type=float)
    add_set_option(parser, "start values: component.variable=VALUE; arrays as 'x=1 2 3'")
    files = {
        "--input FILE.csv|FILE.parquet": "table with a column time [s] and one per input, "
        "interpolated linearly (default: the input in the package)",
        "--out FILE.csv|FILE.parquet": "file for the recorded signals",
        "--save FILE": "file for the state at --until",
        "--resume FILE": "continue from a saved state",
    }
    add_options(parser, files, type=Path)
    several = {
        "--hold COLUMN": "columns of --input that are held instead of interpolated",
        "--record NAME": "names or patterns (drive.*) of signals (default: all outputs and inputs)",
    }
    add_options(parser, several, **SEVERAL)
    add_options(parser, {"--allow-nan": "continue when an output is NaN or infinite"}, **FLAG)
    add_options(parser, {"--variant NAME": "variant of the .ssp to load, if it has several"})
    points = parser.add_mutually_exclusive_group()
    add_options(points, {"--every N": "record every N-th point"}, type=int, default=1)
    add_options(points, {"--last": "record only the last point"}, **FLAG)
    add_isolation(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Run, write the samples if asked to, and print the range and end of each signal."""
    if options.out:
        require_regular_file(options.out)
    with writable(options.out.parent) if options.out else nullcontext():
        _simulate(options)


def _simulate(options: argparse.Namespace) -> None:
    model = Model.open(options.file, options.variant)
    for name, value in split_assignments(options.set).items():
        model.system.set(model.qualified(name), value)
    inputs = model.inputs
    if options.look is not None and options.real_time is None:
        raise UsageError("--look is for --real-time; give it")
    if options.hold and not options.input:
        raise UsageError("--hold names columns of --input; give one")
    if options.input:
        tables = cosim.read_tables(options.input, options.hold)
        inputs = {model.exposed(name): table for name, table in tables.items()}
    prepared = model.prepare(
        stop=options.stop,
        step=options.step,
        record=model.record(options.record, options.every, "last" if options.last else "all"),
        tolerance=options.tolerance,
        allow_nan=options.allow_nan,
        isolation=isolation_of(options),
    )
    with prepared as simulation:
        pace = options.real_time
        if pace is not None and options.look is not None:
            pace = cosim.RealTimePacing(pace, options.look)
        how = {"inputs": inputs, "until": options.until, "real_time": pace}
        if options.resume:
            result = simulation.resume(options.resume, **how)
        else:
            result = simulation.run(**how)
        if options.save:
            simulation.save(options.save)
        pacing = simulation.pacing
    if options.out:
        write = result.to_parquet if options.out.suffix == ".parquet" else result.to_csv
        write(options.out)
    print(f"{'signal':32} {'unit':8} {'min':>14} {'max':>14} {'end':>14}")
    for name in result.names if len(result.time) else ():  # a resumed run may keep no point
        signal, unit = result[name], result.units[name] or ""
        print(f"{name:32} {unit:8} {signal.min():14.6g} {signal.max():14.6g} {signal[-1]:14.6g}")
    if pacing:
        print(
            f"real time: late {pacing.overruns} of {pacing.looks} times by more than"
            f" {pacing.interval} s, at most {max(0.0, pacing.worst):.3g} s"
        )
