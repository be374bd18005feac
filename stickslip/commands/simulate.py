"""``stickslip simulate``: run a system of FMUs (.ssp) or one FMU.

stickslip simulate drive.fmu --stop 2 --set u=10 --plot
stickslip simulate loop.ssp --input command.csv --record drive.v --out run.csv
"""

from __future__ import annotations

import argparse
import io
import json
import sys
import warnings
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stickslip.commandline import FLAG, SEVERAL, add_options, or_, warn
from stickslip.commandline.assignments import add_set_option, split_assignments
from stickslip.errors import UsageError
from stickslip.fmi.files import atomic_write, require_regular_file
from stickslip.fmi.messages import installing
from stickslip.output import LOG, Answer
from stickslip.storage import writable

if TYPE_CHECKING:
    from stickslip import cosim
    from stickslip.simulation import Model


def add_isolation(parser: argparse.ArgumentParser) -> None:
    """Declare ``--isolate`` and its limits."""
    parser.add_argument(
        "--isolate",
        action=argparse.BooleanOptionalAction,
        help="run the FMUs in a child process, so that a crash does not end the command (default "
        "on Linux, unless this installation compiled all of them)",
    )
    limits = {
        "--timeout S": "with isolation: time limit of the run (default: 30 s for each step)",
        "--memory MB": "with isolation: memory limit (Linux, default 4096)",
    }
    add_options(parser, limits, type=float)
    allow = {
        "--allow network|exec|files=DIR|env=NAME": "with isolation: what the sandbox lets the FMUs "
        "do; may be repeated (Linux)"
    }
    add_options(parser, allow, action="append")


def isolation_of(options: argparse.Namespace) -> cosim.Isolated:
    """Return what the options ask for; raise UsageError when a limit is given without isolation."""
    from stickslip import cosim

    given = {"timeout": options.timeout, "memory": options.memory}
    limits: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    if options.allow:
        limits["allow"] = tuple(options.allow)
    limited = options.isolate or (options.isolate is None and sys.platform == "linux")
    if limits and not limited:
        raise UsageError(f"--{next(iter(limits))} needs --isolate, which it limits")
    if limits or options.isolate:
        return cosim.Isolation(**limits)
    return "foreign" if options.isolate is None else None


PICTURES = (".png", ".svg", ".pdf")
WRITERS = {".parquet": "to_parquet", ".xlsx": "to_excel"}
"""Methods of a result, by suffix; a .csv is written as the run goes."""
LIBRARIES = {".parquet": ("pyarrow", "parquet"), ".xlsx": ("openpyxl", "excel")}
"""What a suffix needs, and the extra that installs it."""
SIGNAL = ("signal", "unit", "min", "max", "end")
WINDOW = Path()


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("file", type=Path, metavar="FILE.ssp|FILE.fmu")
    numbers = {
        "--stop S": "stop time, instead of that of the file",
        "--step S": "communication step, instead of that of the file; where it proposes none, the "
        "smallest of its FMUs, or 1/500 of the run",
        "--tolerance REL": "relative tolerance of the solvers, instead of that of the FMUs",
        "--until S": "halt at this time, before the stop",
    }
    add_options(parser, numbers, type=float)
    add_set_option(parser, "start values: component.variable=VALUE; arrays as 'x=1 2 3'")
    files = {
        "--input FILE.csv|FILE.parquet": "table with a column 'time' in s and one per input, "
        "named as it, interpolated linearly (default: the input in the package)",
        "--out FILE.csv|FILE.parquet|FILE.xlsx": "file for the recorded signals",
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
    parser.add_argument(
        "--plot",
        nargs="?",
        type=_picture,
        const=WINDOW,
        metavar="FILE.png|FILE.svg|FILE.pdf",
        help="draw the recorded signals, without a file in a window, or where there is none, into "
        "a .png named like the model",
    )
    points = parser.add_mutually_exclusive_group()
    add_options(points, {"--every N": "record every N-th point"}, type=int, default=1)
    add_options(points, {"--last": "record only the last point"}, **FLAG)
    add_isolation(parser)
    parser.set_defaults(run=run)


def _picture(text: str) -> Path:
    """Return the file of a plot."""
    if Path(text).suffix not in PICTURES:
        raise argparse.ArgumentTypeError(f"{text}: expected a file that ends in {or_(PICTURES)}")
    return Path(text)


def run(options: argparse.Namespace) -> Answer:
    """Run, write the samples if asked to, and print the range and end of each signal."""
    if options.out and options.out.suffix not in (tables := (".csv", *WRITERS)):
        raise UsageError(f"{options.out}: expected a file that ends in {or_(tables)}")
    library, extra = LIBRARIES.get(options.out.suffix, ("", "")) if options.out else ("", "")
    if library and find_spec(library) is None:  # before a run whose result it would lose
        raise UsageError(f"{options.out}: needs {library}; install it with {installing(extra)}")
    if options.hold and not options.input:
        raise UsageError("--hold names columns of --input; give one")
    read = [file.resolve() for file in (options.file, options.input) if file]
    for option in ("out", "save", "plot"):
        if (file := getattr(options, option)) and file.resolve() in read:
            raise UsageError(f"--{option} {file}: is what the run reads; choose another name")
    with ExitStack() as folders:
        for file in (options.out, options.plot):
            if file and file != WINDOW:
                require_regular_file(file)
                folders.enter_context(writable(file.parent))
        return _simulate(options)


def _simulate(options: argparse.Namespace) -> Answer:
    from stickslip import cosim
    from stickslip.simulation import Model

    model = Model.open(options.file, options.variant)
    given = cosim.read_tables(options.input, options.hold) if options.input else None
    inputs = model.signals(given)
    if options.input and not inputs:
        names = ", ".join(model.system.inputs) or "none"
        raise UsageError(
            f"{options.input}: expected a column for an exposed input ({names}) beside 'time'"
        )
    starts = split_assignments(options.set)
    model.require_free(starts, inputs)
    for name, value in starts.items():
        model.set(name, value)
    with _shown_warnings():
        prepared = model.prepare(
            stop=options.stop,
            step=options.step,
            record=model.record(options.record, options.every, _kept(options)),
            tolerance=options.tolerance,
            allow_nan=options.allow_nan,
            isolation=isolation_of(options),
        )
    with prepared as simulation:
        writer = WRITERS.get(options.out.suffix) if options.out else None
        how = {"inputs": inputs, "until": options.until}
        how["out"] = None if writer else options.out
        if options.resume:
            result = simulation.resume(options.resume, **how)
        else:
            result = simulation.run(**how)
        if options.save:
            simulation.save(options.save)
    _warn(options, model, inputs, simulation.spec)
    written = [options.out] if options.out else []
    if writer:
        getattr(result, writer)(options.out)
    print(f"{'signal':32} {'unit':8} {'min':>14} {'max':>14} {'end':>14}")
    signals = []
    for name in result.names if len(result.time) else ():  # a resumed run may keep no point
        values, unit = result[name], result.units[name]
        ends = values.min(), values.max(), values[-1]
        signals.append(dict(zip(SIGNAL, (name, unit, *ends), strict=True)))
        print(f"{name:32} {unit or '':8} " + " ".join(f"{value:14.6g}" for value in ends))
    last = {name: texts[-1] for name, texts in result.texts.items() if texts}
    for name, text in last.items():
        print(f"{name:32} {json.dumps(text, ensure_ascii=False)} at the end")
    if options.plot is not None:
        written += _plot(result, options.plot, options.file)
    for file in written:
        print(file)
    times = {"start": simulation.spec.start, "stop": simulation.spec.stop}
    return Answer(
        {"file": options.file, **times, "step": simulation.spec.step, "stopped": result.stopped}
        | {"points": result.points, "signals": signals, "texts": last, "written": written}
    )


def _kept(options: argparse.Namespace) -> str:
    """Return what to keep: no more than is printed, where no table, picture or state needs all."""
    if options.last:
        return "last"
    table = options.out if options.out and options.out.suffix in WRITERS else None
    needed = table, options.plot, options.save, options.resume
    return "range" if needed == (None, None, None, None) else "all"


@contextmanager
def _shown_warnings() -> Iterator[None]:
    """Show the warnings of the Python API as those of a command."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield
    for one in caught:
        warn(str(one.message))


def _warn(
    options: argparse.Namespace,
    model: Model,
    inputs: Mapping[str, object],
    spec: cosim.Specification,
) -> None:
    """Warn of inputs that end or have no values, and name what was chosen without a proposal."""
    from stickslip import cosim

    with _shown_warnings():
        model.warn_of_idle(inputs, components=True)
    if not options.record and not model.has_outputs:
        warn(f"{options.file}: there are no outputs; local variables are recorded")
    if options.step is None and model.experiment.step is None:
        LOG.info("%s: the file proposes no step; %g s is used", options.file, spec.step)
    tables = [one for one in inputs.values() if isinstance(one, cosim.Table) and len(one.time) > 1]
    ends, stop = [one.time[-1] for one in tables if not one.held], spec.stop
    if options.input and ends and max(ends) < stop - spec.step and options.until is None:
        held = f"its last values hold until {stop:g} s"
        warn(f"{options.input}: ends at {max(ends):g} s; {held}")


def _plot(result: cosim.Result, file: Path, model: Path) -> list[Path]:
    """Draw the signals into a file or a window; return the file."""
    if not len(result.time) or not result.names:
        warn("nothing was recorded that could be drawn")
        return []
    import matplotlib as mpl  # late, for those who only simulate
    from matplotlib import pyplot as plt

    if file != WINDOW:
        mpl.use("agg")
    result.plot()
    figure = plt.gcf()
    if file == WINDOW:
        if figure.canvas.required_interactive_framework:
            plt.show()
            return []
        file = Path(f"{model.stem}.png")
    stream = io.BytesIO()
    figure.savefig(stream, format=file.suffix[1:], dpi=150)
    plt.close(figure)
    return [atomic_write(file, stream.getvalue())]
