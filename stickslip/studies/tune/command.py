"""``stickslip tune``: search the gains and compensators of a drive, or parameters of a system.

stickslip tune axis/learned.json --out tuned
stickslip tune loop.ssp --set-range controller.K_p=1e3:1e4 --cost cost.toml --out tuned
"""

import argparse
import math
from pathlib import Path
from typing import Any

from stickslip.commandline import SEVERAL, add_options, at_least, positive, require_files, warn
from stickslip.commandline.assignments import split_assignments
from stickslip.commandline.execution import add_algorithm_option
from stickslip.commandline.log_options import add_rig_option, rig_of
from stickslip.commandline.progress import TerminalProgress
from stickslip.errors import UsageError
from stickslip.output import Answer
from stickslip.storage import reserved
from stickslip.studies.tune import MOTIONS
from stickslip.work.jobs import processors


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.description = (
        "Search the gains of a learned drive's controller and the values of its compensators on "
        "the simulated drives that its log supports, so that in no motion the error grows and the "
        "loop stays robust. For a system of FMUs, search the parameters given by --set-range for "
        "the least cost of --cost."
    )
    parser.add_argument("file", nargs="?", type=Path, metavar="LEARNED.json|LOOP.ssp")
    add_rig_option(parser, "run the present loop, the tuned one and loops between on this drive")
    most = {"--motions N": f"of --rig: budget of motions of the drive (default: {MOTIONS})"}
    add_options(parser, most, type=at_least(2), default=MOTIONS)
    several = {
        "--set-range NAME=LOW:HIGH": "range of component.variable, such as controller.K_p; of a "
        "learned drive instead of or beside those that are searched by default",
        "--fixed NAME": "parameters, or a component such as controller, that stay as they are",
    }
    add_options(parser, several, **SEVERAL)
    files = {
        "--cost FILE.toml": "of a system: signals, references, weights and windows",
        "--input FILE.csv": "of a system: table of its inputs",
        "--out DIR": "folder for results and page",
    }
    add_options(parser, files, type=Path)
    times = {"--stop S": "of a system: stop time", "--step S": "of a system: communication step"}
    limit = {"--force-limit N": "of a learned drive: force or torque of the motor, in SI units"}
    add_options(parser, times | limit, type=positive)
    tried = {"--evaluations N": "number of loops that are tried (default: 300)"}
    add_options(parser, tried, type=at_least(1), default=300)
    workers = {"--workers N": "number of loops that run in parallel (default: processors)"}
    add_options(parser, workers, type=at_least(1), default=processors())
    add_options(parser, {"--seed S": "random seed of the search"}, type=at_least(0), default=0)
    add_algorithm_option(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> Answer:
    """Tune, print what it brings, and write the results."""
    if options.file is None:
        first = f"stickslip learn --rig {options.rig} --out DIR" if options.rig else "learn"
        raise UsageError(f"expected LEARNED.json or LOOP.ssp; run '{first}' first")
    require_files(options.file, options.cost, options.input, options.rig)
    ranges = ranges_of(options.set_range)
    learned = options.file.suffix == ".json"
    other = ("cost", "input", "stop", "step") if learned else ("fixed", "force_limit", "rig")
    if given := [name for name in other if getattr(options, name)]:
        kind = "a learned drive" if learned else "a system"
        raise UsageError(f"--{given[0].replace('_', '-')}: is not an option of {kind}")
    from stickslip.studies.tune.writing import FILES

    with reserved(options.out, FILES):
        return Answer((_of_drive if learned else _of_system)(options, ranges))


def ranges_of(texts: list[str]) -> dict[str, tuple[float, float]]:
    """Return lowest and highest value by name; raise UsageError when a text is no range."""
    found = {}
    for name, text in split_assignments(texts, "--set-range").items():
        try:
            low, high = map(float, text.split(":"))
        except ValueError:
            low = high = math.nan
        if not -math.inf < low < high < math.inf:
            raise UsageError(f"--set-range {name}={text}: expected NAME=LOW:HIGH, LOW below HIGH")
        found[name] = low, high
    return found


def _of_drive(
    options: argparse.Namespace, ranges: dict[str, tuple[float, float]]
) -> dict[str, Any]:
    from stickslip.learned.file import LearnedFile
    from stickslip.studies.learn import tables
    from stickslip.studies.tune.interface import tune
    from stickslip.studies.tune.writing import parameters, tuned_document, write_tuned

    names = ("fixed", "force_limit", "motions", "evaluations", "algorithm", "seed", "workers")
    given: dict[str, Any] = {name: getattr(options, name) for name in names}
    learned = LearnedFile(options.file)
    with (
        TerminalProgress() as progress,
        rig_of(options.rig, options.out, learned.law.name) as (rig, _),
    ):
        if rig is not None and "observer.fmu" in learned.written:
            warn("an observer would have to run in the drive: the loop is tuned without it")
        found: Any = tune(options.file, ranges, rig=rig, progress=progress, **given)
    print(parameters(found).text())
    for figure, table in tables.errors(found.benefit) if found.is_better else ():
        print(
            f"\nRMS error of {figure} against the command over that of the present loop, median"
            " of simulated drives"
            f" (where that of the true one is expected):\n{table.text()}"
        )
    if found.on_rig:
        print(f"\n{found.on_rig.table.text()}\n{found.on_rig.sentence}")
    print(f"\n{found.sentence}")
    if options.out:
        write_tuned(found, options.out)
        print(f"all results are in {options.out}; open report.html first")
    return {**tuned_document(found)["tuning"], "folder": options.out}


def _of_system(
    options: argparse.Namespace, ranges: dict[str, tuple[float, float]]
) -> dict[str, Any]:
    from stickslip import cosim
    from stickslip.studies.tune.interface import tune
    from stickslip.studies.tune.writing import changed, sentence_of, write_optimised

    if not (ranges and options.cost):
        what = f"{options.file}: a system is tuned with --set-range and --cost"
        if options.file.is_dir():
            what = f"{options.file}: a folder; expected its learned.json or tuned.json"
        raise UsageError(what)
    names = ("evaluations", "algorithm", "seed", "workers", "stop", "step")
    given: dict[str, Any] = {name: getattr(options, name) for name in names}
    if options.input:
        given["inputs"] = cosim.read_tables(options.input)
    with TerminalProgress() as progress:
        progress.stage(f"tuning {', '.join(ranges)}")
        found: Any = tune(options.file, ranges, options.cost, progress=progress, **given)
    print(changed(found).text(), f"\n{sentence_of(found)}", sep="\n")
    if options.out:
        write_optimised(found, options.file, options.cost, options.out)
        print(f"all results are in {options.out}; open report.html first")
    return {"parameters": changed(found).by_key(), "cost": found.cost, "folder": options.out}
