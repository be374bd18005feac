"""The child process: tries the rules of a stage one after the other and tells what each found.

One line of JSON begins and one ends each rule, so that the parent knows which one was being tried
when the process died. Each line begins with the token of the job: the FMU may write into the
report too.
"""

import json
import pickle
import secrets
import time
import traceback
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import IO, Any

from stickslip.fmi.process import sandbox
from stickslip.fmi.process.child import limit
from stickslip.fmucheck import rules
from stickslip.fmucheck.description.model import Description
from stickslip.fmucheck.running.bench import Bench, Spent
from stickslip.fmucheck.running.calls import CallFailed
from stickslip.fmucheck.running.plain_run import GATES, LOADING, settings

MEMORY = 4096.0  # MB


@dataclass(frozen=True)
class Job:
    """What a child is to do; each line of its report begins with the token."""

    stage: str
    description: Description
    libraries: dict[str, Path]  # interface -> its binary
    resources: Path
    first: dict[str, dict[str, str]]  # interface -> what an earlier process found out
    token: str = field(default_factory=lambda: secrets.token_hex(16))
    tried: frozenset[tuple[str, str]] = frozenset()  # interfaces and rules, by other children
    sandbox: dict[str, Any] | None = None  # the arguments with which it is entered


def main(job_file: str, report_file: str) -> None:
    """Try every rule of the job's stage that was not tried yet, on every interface."""
    before = settings()
    limit(MEMORY)
    job: Job = pickle.loads(Path(job_file).read_bytes())  # noqa: S301 (written by the parent)
    with Path(report_file).open("a", encoding="utf-8") as report:
        if job.sandbox:
            sandbox.enter(**job.sandbox)
        for interface in job.description.interfaces:
            library = job.libraries.get(interface.kind)
            if library and library.exists():  # an FMU may have deleted it
                first = job.first.get(interface.kind, {})
                given = interface, library, job.resources, before, first
                bench = Bench(job.description, *given, dict(first))
                _try(job, bench, report)
                if bench.is_spent:  # the rest needs a process of its own
                    _tell(job, report, end=True, again=True)
                    return
        _tell(job, report, end=True)


def _try(job: Job, bench: Bench, report: IO[str]) -> None:
    kind = bench.interface.kind
    bench.tick = partial(_tell, job, report)
    for rule in rules.stage(job.stage):
        applies = job.description.version in rule.sections
        if kind == "ScheduledExecution":
            applies = applies and rule.id in LOADING
        if applies and (kind, rule.id) not in job.tried:
            _tell(job, report, begin=[kind, rule.id])
            bench.began = time.monotonic()
            claims, reasons = _claims(bench, rule)
            _tell(job, report, claims=claims, reasons=reasons, results=bench.results)
            if bench.is_spent or (rule.id in GATES and (claims or "call-fails" in reasons)):
                return


def _claims(bench: Bench, rule: rules.Rule) -> tuple[list[tuple[str, str]], dict[str, str]]:
    """Return what a rule finds, and why it could not be tried to its end, see ``Ending``."""
    claims: list[tuple[str, str]] = []
    reasons: dict[str, str] = {}
    try:
        claims += rule.check(bench)
    except CallFailed as fault:
        reasons["call-fails"] = f"{fault}{bench.last_words()}"
    except Spent:
        reasons["spent"] = rule.id
    except Exception:  # noqa: BLE001 (an error in stickslip is not a fault of the FMU)
        reasons["rule-not-tried"] = traceback.format_exc()
    bench.close()
    return claims, reasons


def _tell(job: Job, report: IO[str], **what: object) -> None:
    report.write(f"\n{job.token}{json.dumps(what)}\n")
    report.flush()
