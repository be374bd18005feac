"""``stickslip simulate``: run a system of FMUs, or one FMU."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from stickslip import cosim
from stickslip.commands.assignments import add_set_option, split_assignments
from stickslip.commands.default_input import packed_input
from stickslip.commands.isolation import add_isolation, isolation_of
from stickslip.errors import UsageError
from stickslip.fmi.toolchain import refuse_odd
from stickslip.results.folder import writable

_STEPS = 500  # of an FMU that proposes no step


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("file", type=Path, metavar="FILE.ssp|FILE.fmu")
    parser.add_argument("--stop", type=float, metavar="S", help="instead of the file's own")
    parser.add_argument(
        "--step",
        type=float,
        metavar="S",
        help="communication step, likewise; 1/500 of the time of an FMU that proposes none",
    )
    add_set_option(parser, "start values: component.variable=VALUE, of arrays 'x=1 2 3'")
    parser.add_argument(
        "--input",
        type=Path,
        metavar="FILE.csv|FILE.parquet",
        help="a column time [s] and one per input, linear in between; a packed input otherwise",
    )
    parser.add_argument(
        "--hold",
        nargs="+",
        action="extend",
        default=[],
        metavar="COLUMN",
        help="columns of --input whose values hold until the next time",
    )
    parser.add_argument(
        "--tolerance", type=float, metavar="REL", help="of solvers, instead of the FMUs' own"
    )
    parser.add_argument(
        "--allow-nan", action="store_true", help="go on where an output is NaN or infinite"
    )
    parser.add_argument("--variant", metavar="NAME", help="of an .ssp with several systems")
    parser.add_argument("--until", type=float, metavar="S", help="halt there, before the stop")
    parser.add_argument("--save", type=Path, metavar="FILE", help="the state at --until, to resume")
    parser.add_argument("--resume", type=Path, metavar="FILE", help="go on from a saved state")
    parser.add_argument(
        "--real-time", type=float, metavar="FACTOR", help="simulated s per s, instead of full speed"
    )
    parser.add_argument(
        "--record",
        nargs="+",
        action="extend",
        metavar="NAME",
        help="names or patterns (drive.*); all outputs and inputs by default",
    )
    points = parser.add_mutually_exclusive_group()
    points.add_argument("--every", type=int, default=1, metavar="N", help="keep every N-th point")
    points.add_argument("--last", action="store_true", help="keep the last point alone")
    parser.add_argument(
        "--out", type=Path, metavar="FILE.csv|FILE.parquet", help="write what is kept there"
    )
    add_isolation(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Run, write the samples if asked to, and print the range and end of each signal."""
    if not options.out:
        _simulate(options)
        return
    refuse_odd(options.out)
    with writable(options.out.parent):
        _simulate(options)


def _simulate(options: argparse.Namespace) -> None:
    system, experiment, inputs = _open(options.file, options.variant)
    for name, value in split_assignments(options.set).items():
        system.set(_qualified(system, name), value)
    lone = options.file.suffix == ".fmu"
    if lone:
        _expose_inputs(system)
    if options.hold and not options.input:
        raise UsageError("--hold names columns of --input; give one")
    if options.input:
        tables = cosim.read_tables(options.input, options.hold)
        inputs = {_exposed(system, name): table for name, table in tables.items()}
    experiment = replace(
        experiment,
        stop=experiment.stop if options.stop is None else options.stop,
        step=experiment.step if options.step is None else options.step,
    )
    if lone and experiment.stop is not None and experiment.step is None:
        span = experiment.stop - (experiment.start or 0.0)
        experiment = replace(experiment, step=span / _STEPS)
    if experiment.stop is None or experiment.step is None:
        missing = "stop" if experiment.stop is None else "step"
        raise UsageError(f"{options.file}: the file proposes no {missing}; give --{missing}")
    names = options.record and [_qualified(system, name) for name in options.record]
    record = cosim.Record(names, options.every, "last" if options.last else "all")
    isolation = isolation_of(options)
    try:
        prepared = system.prepare(
            start=experiment.start or 0.0,
            stop=experiment.stop,
            step=experiment.step,
            record=record,
            tolerance=options.tolerance,
            allow_nan=options.allow_nan,
            isolation=isolation,
        )
    except cosim.ExperimentError as fault:
        hint = "" if "tolerance" in str(fault) else "; see --stop and --step"
        raise UsageError(f"{options.file}: {fault}{hint}") from fault
    with prepared as simulation:
        how = {"inputs": inputs, "until": options.until, "real_time": options.real_time}
        if options.resume:
            result = simulation.resume(options.resume, **how)
        else:
            result = simulation.run(**how)
        if options.save:
            simulation.save(options.save)
        pace = simulation.pace
    if options.out:
        write = result.to_parquet if options.out.suffix == ".parquet" else result.to_csv
        write(options.out)
    print(f"{'signal':32} {'unit':8} {'min':>14} {'max':>14} {'end':>14}")
    for name in result.names if len(result.time) else ():  # a resumed run may keep no point
        signal, unit = result[name], result.units[name] or ""
        print(f"{name:32} {unit:8} {signal.min():14.6g} {signal.max():14.6g} {signal[-1]:14.6g}")
    if pace:
        print(
            f"real time: late {pace.overruns} of {pace.looks} times by more than"
            f" {pace.interval} s, at most {max(0.0, pace.worst):.3g} s"
        )


def _open(
    path: Path, variant: str | None
) -> tuple[cosim.System, cosim.DefaultExperiment, Mapping[str, cosim.Table]]:
    """Return the system in a file, the times it proposes and the input packed with it."""
    if path.suffix == ".ssp":
        return *cosim.read_ssp(path, variant), packed_input(path)
    if path.suffix != ".fmu":
        raise UsageError(f"{path}: expected a file .ssp or .fmu")
    if variant is not None:
        raise UsageError(f"{path}: --variant names a system of an .ssp; this is one FMU")
    fmu = cosim.Fmu(path)
    system = cosim.System(path.stem)
    system.add(fmu.identifier, fmu)
    return system, fmu.experiment, {}


def _expose_inputs(system: cosim.System) -> None:
    """Expose the inputs of the only component, those that are arrays by element."""
    ((name, fmu),) = system.components.items()
    inputs = (v.name for v in fmu.variables.values() if v.causality == "input")
    for element in (e for v in inputs for e in system.variable(f"{name}.{v}").elements()):
        if element.is_signal:
            system.expose(element.name.replace(".", "_"), f"{name}.{element.name}")


def _exposed(system: cosim.System, column: str) -> str:
    """Return the input that a column feeds: named so, or as the variable, dots and all."""
    return column if column in system.inputs else column.replace(".", "_")


def _qualified(system: cosim.System, name: str) -> str:
    """Return component.variable, of a lone component also for the variable alone."""
    components = list(system.components)
    first = name.partition(".")[0]
    if len(components) > 1 or first in components or name in system.inputs:
        return name
    return f"{components[0]}.{name}"
