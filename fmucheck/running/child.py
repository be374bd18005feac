"""The child process: tries the rules of a stage one after the other and tells what each found.

One line of JSON begins and one ends each rule, so
that the parent knows which one was being tried when the process died.
"""

from __future__ import annotations

import json
import pickle
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import fmucheck.rules
from fmucheck.description.model import Description
from fmucheck.running.bench import Bench
from fmucheck.running.calls import CallFailed
from fmucheck.running.loading import GATES

MEMORY = 4 * 1024**3


@dataclass(frozen=True)
class Job:
    """What a child is to do; ``tried`` are the rules that other children have tried before."""

    stage: str
    description: Description
    interface: str
    library: Path
    resources: Path
    first: dict[str, str]
    tried: frozenset[str]


def main(job_file: str, report_file: str) -> None:
    """Try every rule of the job's stage that was not tried yet."""
    _limit()
    job: Job = pickle.loads(Path(job_file).read_bytes())  # noqa: S301 (written by the parent)
    interface = job.description.interface(job.interface)
    if interface is None:
        return
    bench = Bench(job.description, interface, job.library, job.resources, job.first)
    bench.still = "still" in job.first
    with Path(report_file).open("a", encoding="utf-8") as report:
        for rule in fmucheck.rules.stage(job.stage):
            applies = job.description.version in rule.sections
            if not applies or rule.id in job.tried:
                continue
            _tell(report, begin=rule.id)
            claims = _claims(bench, rule)
            _tell(report, claims=claims, results=bench.results)
            if rule.id in GATES and claims:
                break
        _tell(report, end=True)


def _claims(bench: Bench, rule: fmucheck.rules.Rule) -> list[tuple[str, str]]:
    """Return what a rule finds; a call that fails on the way is a finding, too."""
    try:
        claims = list(rule.check(bench))
    except CallFailed as failed:
        claims = [(bench.interface.kind, str(failed))]
    bench.close()
    return claims


def _tell(report: IO[str], **what: object) -> None:
    report.write(json.dumps(what) + "\n")
    report.flush()


def _limit() -> None:
    """Limit memory and leave no core files, where the system can do that."""
    if sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
