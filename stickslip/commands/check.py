"""``stickslip check``: validate FMUs of any tool."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from stickslip import fmucheck
from stickslip.fmucheck import Report, Severity


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.epilog = "status 0: no errors; 1: errors (with --strict also warnings); 2: usage"
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE.fmu")
    parser.add_argument("--json", action="store_true", help="print findings as JSON")
    parser.add_argument("--strict", action="store_true", help="warnings count as errors")
    parser.add_argument("--no-run", action="store_true", help="do not load the binary")
    parser.add_argument(
        "--timeout",
        type=float,
        default=20.0,
        metavar="S",
        help="time limit of the binary for one rule",
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print what was found; return 1 if any of it is an error."""
    reports = [
        fmucheck.check(path, run=not options.no_run, timeout=options.timeout)
        for path in options.files
    ]
    if options.json:
        print(json.dumps({"version": 1, "files": [r.as_json() for r in reports]}, indent=2))
    else:
        for report in reports:
            _print(report)
    worst = Severity.WARNING if options.strict else Severity.ERROR
    return int(any(finding.severity >= worst for report in reports for finding in report))


def _print(report: Report) -> None:
    counts = [f"{report.count(s)} {s}s" for s in sorted(Severity, reverse=True)]
    version = f"FMI {report.fmi}, " if report.fmi else ""
    print(f"{report.path}: {version}{', '.join(counts)}")
    width = max((len(finding.rule) for finding in report), default=0)
    for finding in report:
        print(
            f"  {finding.severity!s:7}  {finding.rule:{width}}  {finding.place}: {finding.message}"
        )
        indent = " " * (11 + width)
        section = f"  [{finding.section}]" if finding.section else ""
        print(f"{indent}  -> {finding.advice}{section}")
