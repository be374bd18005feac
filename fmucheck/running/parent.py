"""The parent: starts children, watches over them, and survives what they load."""

from __future__ import annotations

import contextlib
import json
import os
import pickle
import platform
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from stickslip.fmi.process import check_interruption, child_process
from stickslip.fmucheck import rules
from stickslip.fmucheck.binaries import target
from stickslip.fmucheck.description.model import Fmu
from stickslip.fmucheck.ending import MOST_TEXT, TELLING, Ending, signal_name
from stickslip.fmucheck.rules import Finding
from stickslip.fmucheck.running.child import Job
from stickslip.fmucheck.running.loading import GATES

Claim = tuple[str, str]

TIMEOUT = 20.0  # s that one rule may take
_MOST_CHILDREN = 8
_MOST_REPORT = 2**28  # bytes; an FMU may write into it too
_UNANIMOUS = ("dependency-never-seen",)
_SYSTEMS = {"linux": ("linux", ".so"), "win32": ("windows", ".dll"), "darwin": ("darwin", ".dylib")}
_PROCESSORS = {"amd64": "x86_64", "arm64": "aarch64", "i386": "x86", "i686": "x86"}


def host_binary(fmu: Fmu, identifier: str) -> str | None:
    """Return the path of the binary for this machine, ``None`` when there is none."""
    system, suffix = _SYSTEMS.get(sys.platform, (sys.platform, ".so"))
    processor = platform.machine().lower()
    here = f"{_PROCESSORS.get(processor, processor)}-{system}"
    for name in fmu.below("binaries/"):
        parts = name.split("/")
        fits = len(parts) == 3 and parts[2] == identifier + suffix
        if fits and target(parts[1], fmu.description.version) == here:
            return name
    return None


def findings_of_runs(
    fmu: Fmu, blocked: set[str], broken: Mapping[str, str], timeout: float = TIMEOUT
) -> Iterator[Finding]:
    """Yield what is found by running every interface of an FMU.

    Parameters
    ----------
    blocked : rules whose findings make running pointless
    broken : binary that cannot be loaded -> the rule that found so
    timeout : s that one rule may take
    """
    libraries = {}
    for interface in fmu.description.interfaces:
        name = host_binary(fmu, interface.identifier)
        reasons = blocked | ({broken[name]} if name and name in broken else set())
        why = f"because of {', '.join(sorted(reasons))}" if reasons else ""
        if not why and name is None:
            why = "there is no binary for this machine"
        if not why and interface.flag("needsExecutionTool"):
            why = "it needs a tool"
        if why or name is None:
            ending = Ending(interface.kind, "", "unable", text=f"was not run: {why}")
            yield from _ended(ending, fmu)
            continue
        libraries[interface.kind] = fmu.folder / name
        if interface.kind == "ScheduledExecution":
            ending = Ending(interface.kind, "", "unable", text="was only loaded and instantiated")
            yield from _ended(ending, fmu)
    if libraries:
        job = Job("running", fmu.description, libraries, fmu.folder / "resources", {})
        results: dict[str, dict[str, str]] = {}
        yield from _tried(job, fmu, timeout, results)
        yield from _tried(replace(job, stage="rerunning", first=results), fmu, timeout, {})


def _ended(ending: Ending, fmu: Fmu) -> Iterator[Finding]:
    if ending.during in TELLING and ending.reason in ("crash", "hang"):
        fatal = f"dies of {signal_name(ending.status)}"
        how = f"does not return in {ending.seconds:g} s" if ending.reason == "hang" else fatal
        claim = ending.interface, f"the process {how}"
        yield rules.RULES[ending.during].finding(claim, fmu.description.version)
        return
    for rule in rules.stage("ending"):
        yield from rule.findings(ending, fmu.description.version)


def _tried(
    job: Job, fmu: Fmu, timeout: float, results: dict[str, dict[str, str]]
) -> Iterator[Finding]:
    """Yield what a stage finds, in as many children as it takes; fill in what they found out."""
    printed = False
    for _ in range(_MOST_CHILDREN):
        child = _Child(job, fmu.folder)
        ending = child.watch(timeout)
        results |= child.results
        for (_, rule), claims in child.claims.items():
            for claim in _agreed(rule, claims, child.claims):
                yield rules.RULES[rule].finding(claim, fmu.description.version)
        for (interface, rule, reason), text in child.failed.items():
            yield from _ended(Ending(interface, rule, reason, text=text), fmu)
        if ending is None:
            if child.text.strip() and not printed:
                yield from _ended(Ending("standard output", "", "printed", text=child.text), fmu)
            return
        printed = True
        yield from _ended(ending, fmu)
        if not ending.during:
            return
        tried = job.tried | {*child.claims, (ending.interface, ending.during)}
        libraries = dict(job.libraries)
        if ending.during in GATES:
            del libraries[ending.interface]
        job = replace(job, libraries=libraries, tried=tried, first=job.first | child.results)


def _agreed(
    rule: str, claims: list[Claim], everywhere: Mapping[tuple[str, str], list[Claim]]
) -> list[Claim]:
    """Return the claims that stand: of some rules those that every interface makes."""
    if rule not in _UNANIMOUS:
        return claims
    places = [{place for place, _ in made} for (_, r), made in everywhere.items() if r == rule]
    return [claim for claim in claims if all(claim[0] in made for made in places)]


@dataclass
class _Child:
    job: Job
    folder: Path
    claims: dict[tuple[str, str], list[Claim]] = field(default_factory=dict)
    failed: dict[tuple[str, str, str], str] = field(default_factory=dict)
    results: dict[str, dict[str, str]] = field(default_factory=dict)
    text: str = ""

    def watch(self, timeout: float) -> Ending | None:
        """Run the child until it ends or has to be ended; ``None`` when all went well."""
        room = self.folder.parent / f"{self.folder.name}-run"
        room.mkdir(exist_ok=True)
        job, report, output = (room / name for name in ("job", "report", "output"))
        job.write_bytes(pickle.dumps(self.job))
        report.write_text("")
        command = [sys.executable, "-m", "stickslip.fmucheck.running", str(job), str(report)]
        with (
            output.open("wb") as stream,
            child_process(
                command,
                stdin=subprocess.DEVNULL,
                stdout=stream,
                stderr=stream,
                cwd=room,
                env=os.environ | {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p)},
            ) as process,
        ):
            reason = self._wait(process, report, output, timeout)
        with output.open("rb") as printed:
            self.text = printed.read(2000).decode("utf-8", "replace")
        interface, during, done = self._read(report)
        status = process.returncode if reason == "exit" else None
        if done and status == 0:
            return None
        if done:
            interface, during = "unloading the library", ""
        if reason == "exit" and (status or 0) < 0:
            reason = "crash"
        return Ending(interface, during, reason, status, self.text, timeout)

    def _wait(
        self, process: subprocess.Popen[bytes], report: Path, output: Path, timeout: float
    ) -> str:
        """Return why the child has to be ended, or that it ended."""
        size_before, since = 0, time.monotonic()
        while True:
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(0.02)
                return "exit"
            size = report.stat().st_size
            if size > size_before:
                size_before, since = size, time.monotonic()
            check_interruption()
            if time.monotonic() - since > timeout:
                return "hang"
            if output.stat().st_size > MOST_TEXT or size > _MOST_REPORT:
                return "flood"

    def _read(self, report: Path) -> tuple[str, str, bool]:
        """Store the child's reports; return the rule that it was trying and whether it finished."""
        interface, during, done = "", "", False
        for line in report.read_text(encoding="utf-8", errors="replace").split("\n"):
            if not line.startswith(self.job.token):
                continue  # an FMU wrote it
            try:
                message = json.loads(line.removeprefix(self.job.token))
            except ValueError:
                continue  # the child died while it wrote
            if "begin" in message:
                interface, during = message["begin"]
            elif "claims" in message:
                claims = [(place, message) for place, message in message["claims"]]
                self.claims[interface, during] = claims
                for reason in ("failed", "puzzled"):
                    if message[reason]:
                        self.failed[interface, during, reason] = message[reason]
                self.results[interface] = message["results"]
            done = done or "end" in message
        return interface, during, done
