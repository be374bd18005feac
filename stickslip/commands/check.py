"""``stickslip check``: validate FMUs of any tool."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

from stickslip.commands import FLAG, add_options, seconds
from stickslip.errors import UsageError
from stickslip.fmi.process.sandbox import Permissions
from stickslip.output import Answer

if TYPE_CHECKING:
    from stickslip.fmucheck import Report


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.epilog = "status 0: no errors; 1: errors (with --strict also warnings); 2: usage"
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE.fmu")
    flags = {
        "--strict": "warnings count as errors",
        "--no-run": "do not load the binary",
    }
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
    reports = [
        fmucheck.check(
            path,
            run=not options.no_run,
            timeout=options.timeout,
            total=options.total,
            allow=options.allow,
        )
        for path in options.files
    ]
    for report in reports:
        _print(report)
    levels = fmucheck.Severity
    worst = levels.WARNING if options.strict else levels.ERROR
    status = int(any(finding.severity >= worst for report in reports for finding in report))
    return Answer({"version": 1, "files": [r.as_json() for r in reports]}, status)


def _print(report: Report) -> None:
    from stickslip.fmucheck import Severity

    counts = [f"{report.count(s)} {s}s" for s in sorted(Severity, reverse=True)]
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
