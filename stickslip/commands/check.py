"""``stickslip check``: validate FMUs and systems of any tool.

stickslip check compensator.fmu
stickslip check plant.fmu --strict --timeout 5
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from stickslip.commandline import FLAG, add_options, seconds
from stickslip.errors import UsageError
from stickslip.fmi.process.sandbox import Permissions
from stickslip.output import Answer

if TYPE_CHECKING:
    from stickslip.fmucheck import Report


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.epilog = "status 0: no errors; 1: errors (with --strict also warnings); 2: usage"
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE.fmu|FILE.ssp")
    flags = {"--strict": "warnings count as errors", "--no-run": "do not load the binary"}
    add_options(parser, flags, **FLAG)
    limit = {"--timeout S": "time limit of the binary for one rule"}
    add_options(parser, limit, type=seconds, default=20.0)
    total = {"--total S": "time limit for each file; what is known by then is printed"}
    add_options(parser, total, type=seconds, default=math.inf)
    name = "--allow network|exec|files=DIR|env=NAME"
    allow = {name: "what the sandbox lets FMUs do; may be repeated"}
    add_options(parser, allow, action="append", default=[])
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> Answer:
    """Print what was found; status 1 if any of it is an error."""
    from stickslip import fmucheck

    try:
        Permissions.of(options.allow)
    except ValueError as fault:
        raise UsageError(f"--{fault}") from None
    check = partial(
        fmucheck.check,
        run=not options.no_run,
        timeout=options.timeout,
        total=options.total,
        allow=options.allow,
    )
    reports: list[Report] = []
    for path in _files(options.files):
        reports += _package(path, check) if path.suffix == ".ssp" else [check(path)]
    for report in reports:
        _print(report)
    levels = fmucheck.Severity
    worst = levels.WARNING if options.strict else levels.ERROR
    status = int(any(finding.severity >= worst for report in reports for finding in report))
    return Answer({"version": 1, "files": [r.as_json() for r in reports]}, status)


def _files(given: Iterable[Path]) -> Iterator[Path]:
    """Yield the files, and of a folder the FMUs and packages in it."""
    from stickslip.logs.formats import SUFFIXES

    kinds = {".fmu", ".ssp"}
    for path in given:
        if path.suffix in (".csv", *SUFFIXES):
            how = f"'stickslip learn {path} --check' checks a log"
            raise UsageError(f"{path}: expected a .fmu or .ssp; {how}")
        if path.suffix in kinds or not path.is_dir():
            yield path
        elif inside := sorted(one for one in path.rglob("*") if one.suffix in kinds):
            yield from inside
        else:
            raise UsageError(f"{path}: a folder without a .fmu or .ssp; name a file")


def _package(path: Path, check: Callable[[Path], Report]) -> list[Report]:
    """Return the report on a package, whose systems are read, and one on each FMU in it."""
    from stickslip.cosim import CosimError, read_ssp, variants
    from stickslip.cosim.ssp.structure import unpacked
    from stickslip.fmucheck import Finding, Report, Severity

    path.stat()
    package = Report(path)
    fmus: dict[Path, Path] = {}

    def note(place: str, fault: CosimError) -> None:
        text = str(fault).removeprefix(f"{path.absolute()}: ")
        advice = "correct the package; simulate refuses it so"
        found = Finding(Severity.ERROR, "system-structure", place, text, section="", advice=advice)
        package.findings.append(found)

    try:
        folder = unpacked(path.absolute())
        inside = sorted(file for file in folder.rglob("*.fmu") if file.is_file())
        fmus = {file: path / file.relative_to(folder) for file in inside}
        for variant in variants(path):
            try:
                for component in read_ssp(path, variant)[0].fmus("check").values():
                    fmus.setdefault(component.path, path / component.label)
            except CosimError as fault:
                note(variant, fault)
    except CosimError as fault:
        note(path.name, fault)
    return [package, *(replace(check(file), path=name) for file, name in fmus.items())]


def _print(report: Report) -> None:
    from stickslip.fmucheck import Severity

    each = [(report.count(one), one) for one in sorted(Severity, reverse=True)]
    counts = [f"{n} {one}{'s' * (n != 1)}" for n, one in each]
    version = f"FMI {report.fmi}, " if report.fmi else ""
    print(f"{report.path}: {version}{', '.join(counts)}")
    width = max((len(finding.rule) for finding in report), default=0)
    for finding in report:
        print(
            f"  {finding.severity!s:7}  {finding.rule:{width}}  {finding.place}: {finding.message}"
        )
        indent = " " * (11 + width)
        if finding.others:
            shown = ", ".join(finding.others[:3])
            dots = ", ..." if finding.count > 4 else ""
            print(f"{indent}  {finding.count} times, also at {shown}{dots}")
        section = f"  [{finding.section}]" if finding.section else ""
        print(f"{indent}  -> {finding.advice}{section}")
