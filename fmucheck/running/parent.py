"""The parent: starts children, watches over them, and survives what they load."""

import contextlib
import json
import math
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from stat import S_ISDIR

from stickslip.fmi.process import check_interruption, child_process, sandbox
from stickslip.fmi.process.guard import Guard
from stickslip.fmi.process.sandbox import Permissions
from stickslip.fmi.toolchain import ToolchainError, host_platform
from stickslip.fmucheck import rules
from stickslip.fmucheck.binaries import target
from stickslip.fmucheck.description.model import Fmu
from stickslip.fmucheck.ending import MOST_TEXT, TELLING, Ending, signal_name
from stickslip.fmucheck.rules import Claim, Finding
from stickslip.fmucheck.running.child import MEMORY, Job
from stickslip.fmucheck.running.plain_run import GATES

TIMEOUT = 20.0  # s that one rule may take
_MOST_CHILDREN = 8
_GRACE = 2.0  # s that the sandbox's guard may take to end after the child
_PACKAGES = ("stickslip", "stickslip.fmi", "stickslip.fmucheck")
_MOST_REPORT = 2**28  # bytes; an FMU may write into it too
_UNANIMOUS = ("dependency-never-seen",)


def host_binary(fmu: Fmu, identifier: str) -> str | None:
    """Return the path of the binary for this machine, ``None`` when there is none."""
    with contextlib.suppress(ToolchainError):
        here = host_platform()
        for name in fmu.below("binaries/"):
            _, folder, *file = name.split("/")
            fits = file == [identifier + here.suffix]
            if fits and target(folder, fmu.description.version) == here.tuple:
                return name
    return None


@dataclass(frozen=True)
class Limits:
    """How long running may take, and what it may do."""

    rule: float = TIMEOUT  # s for one rule
    end: float = math.inf  # of all, by the monotonic clock
    allow: tuple[str, ...] = ()  # what the sandbox lets the binary do, as words of ``--allow``


def findings_of_runs(
    fmu: Fmu, blocked: set[str], broken: Mapping[str, str], limits: Limits
) -> Iterator[Finding]:
    """Yield what running interfaces finds, unless ``blocked`` by rules or ``broken`` itself."""
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
            ending = Ending(interface.kind, "", "not-run", text=f"was not run: {why}")
            yield from _ended(ending, fmu)
            continue
        libraries[interface.kind] = fmu.folder / name
        if interface.kind == "ScheduledExecution":
            ending = Ending(interface.kind, "", "not-run", text="was only loaded and instantiated")
            yield from _ended(ending, fmu)
    if libraries:
        job = Job("running", fmu.description, libraries, fmu.folder / "resources", {})
        results: dict[str, dict[str, str]] = {}
        files = _files(fmu.folder)
        yield from _tried(job, fmu, limits, results)
        yield from _tried(replace(job, stage="rerunning", first=results), fmu, limits, {})
        changed = files.items() ^ _files(fmu.folder).items()
        for name in sorted({name for name, _ in changed}):
            yield from _ended(Ending(name, "", "changes-its-files"), fmu)


def _files(folder: Path) -> dict[str, tuple[int, int]]:
    """Return size and time of change of all files below a folder."""
    found = ((path, path.lstat()) for path in folder.rglob("*"))
    return {
        path.relative_to(folder).as_posix(): (stat.st_size, stat.st_mtime_ns)
        for path, stat in found
        if not S_ISDIR(stat.st_mode)
    }


def _ended(ending: Ending, fmu: Fmu) -> Iterator[Finding]:
    if ending.during in TELLING and ending.rule in ("crash", "hang"):
        fatal = f"dies of {signal_name(ending.status)}"
        how = f"does not return in {ending.seconds:g} s" if ending.rule == "hang" else fatal
        claim = ending.interface, f"the process {how}"
        yield rules.RULES[ending.during].finding(claim, fmu.description.version)
    else:
        yield from rules.RULES[ending.rule].findings(ending, fmu.description.version)


def _tried(
    job: Job, fmu: Fmu, limits: Limits, results: dict[str, dict[str, str]]
) -> Iterator[Finding]:
    """Yield what a stage finds, in as many children as it takes; fill in what they found out."""
    printed, spent = False, list[str]()
    died = 0
    while died < _MOST_CHILDREN:
        child = _Child(job, fmu.folder)
        ending = child.watch(limits)
        results |= child.results
        for (_, rule), claims in child.claims.items():
            for claim in _agreed(rule, claims, child.claims):
                yield rules.RULES[rule].finding(claim, fmu.description.version)
        for (interface, rule, reason), text in child.failed.items():
            if reason == "spent":
                spent.append(rule)
            else:
                yield from _ended(Ending(interface, rule, reason, text=text), fmu)
        for what in child.denied:
            yield from _ended(Ending(what, "", "reaches-outside"), fmu)
        for command in child.left:
            yield from _ended(Ending(command, "", "leaves-a-process"), fmu)
        if ending is None and child.text.strip() and not printed:
            yield from _ended(Ending("standard output", "", "prints", text=child.text), fmu)
        printed = printed or ending is not None or bool(child.text.strip())
        tried, gated = job.tried | child.claims.keys(), _gated(child)
        if ending is not None:
            died += 1
            yield from _ended(ending, fmu)
            tried |= {(ending.interface, ending.during)}
            gated |= {ending.interface} if ending.during in GATES else set()
        if not (child.again if ending is None else ending.during and ending.rule != "not-run"):
            break
        libraries = {kind: path for kind, path in job.libraries.items() if kind not in gated}
        job = replace(job, libraries=libraries, tried=tried, first=job.first | child.results)
    if spent:
        text = f"one instance per process is not enough for {', '.join(dict.fromkeys(spent))}"
        once = "canBeInstantiatedOnlyOncePerProcess"
        yield from _ended(Ending(once, "", "not-run", text=text), fmu)


def _gated(child: "_Child") -> set[str]:
    """Return the interfaces of which nothing more can be tried."""
    claimed = {key for key, claims in child.claims.items() if claims}
    failed = {(kind, rule) for kind, rule, reason in child.failed if reason == "call-fails"}
    return {kind for kind, rule in claimed | failed if rule in GATES}


def _agreed(
    rule: str, claims: list[Claim], everywhere: Mapping[tuple[str, str], list[Claim]]
) -> list[Claim]:
    """Return the claims that stand: of some rules those that every interface makes."""
    if rule not in _UNANIMOUS:
        return claims
    places = [{place for place, _ in made} for (_, r), made in everywhere.items() if r == rule]
    return [claim for claim in claims if all(claim[0] in made for made in places)]


def _left_behind(child: int, mark: str) -> list[str]:
    """End the processes that a child has left in any session; return their commands (Linux)."""
    left = []
    for path in Path("/proc").glob("[0-9]*/environ") if sys.platform == "linux" else ():
        process = int(path.parent.name)
        with contextlib.suppress(OSError):
            if process != child and mark.encode() in path.read_bytes().split(b"\0"):
                left.append((path.parent / "comm").read_text().strip())
                os.kill(process, signal.SIGKILL)
    return left


@dataclass
class _Child:
    job: Job
    folder: Path
    claims: dict[tuple[str, str], list[Claim]] = field(default_factory=dict)
    failed: dict[tuple[str, str, str], str] = field(default_factory=dict)
    results: dict[str, dict[str, str]] = field(default_factory=dict)
    text: str = ""
    again: bool = False
    left: list[str] = field(default_factory=list)
    denied: list[str] = field(default_factory=list)

    def watch(self, limits: Limits) -> Ending | None:
        """Run the child until it ends or has to be ended; ``None`` when all went well."""
        desk = Path(tempfile.mkdtemp(prefix="run-", dir=self.folder.parent))
        room = desk / "room"  # all that the FMU may write: not what is read from it
        room.mkdir()
        job, report, output = (desk / name for name in ("job", "report", "output"))
        allow = Permissions.of(limits.allow)
        guard = self._guarded(room, allow)
        job.write_bytes(pickle.dumps(replace(self.job, sandbox=guard.entry() if guard else None)))
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
                pass_fds=[guard.file] if guard else [],
                env=(allow.environment() if guard else os.environ)
                | {
                    "PYTHONPATH": os.pathsep.join(p for p in sys.path if p),
                    "STICKSLIP_CHECK": self.job.token,
                    **({"TMPDIR": str(room)} if guard else {}),
                },
            ) as process,
        ):
            if guard:
                guard.close_file()
            reason = self._wait(process, report, output, limits)
            self.left = _left_behind(process.pid, f"STICKSLIP_CHECK={self.job.token}")
        if guard:
            guard.end(_GRACE)
            self.denied = [what for _, what in guard.tried]
        with output.open("rb") as printed:
            self.text = printed.read(2000).decode("utf-8", "replace")
        interface, during, done = self._read(report)
        status = process.returncode if reason == "ends-the-process" else None
        if done and status == 0:
            return None
        if done:
            interface, during = "unloading the library", ""
        if reason == "ends-the-process" and (status or 0) < 0:
            reason = "crash"
        text = self.text
        if reason == "not-run":
            text = "the time for all rules is over; it was not run further"
        return Ending(interface, during, reason, status, text, limits.rule)

    def _guarded(self, room: Path, allow: Permissions) -> Guard | None:
        """Return the guard of the sandbox or None; a rule finds when the FMU's files change."""
        if sandbox.unavailable():
            return None
        writable = [str(room), str(self.folder)]
        return Guard.of_python(_PACKAGES, [], writable, allow, MEMORY)

    def _wait(
        self, process: subprocess.Popen[bytes], report: Path, output: Path, limits: Limits
    ) -> str:
        """Return the rule that tells how the child ended or why it has to be ended."""
        size_before, since = 0, time.monotonic()
        while True:
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(0.02)
                return "ends-the-process"
            size = report.stat().st_size
            if size > size_before:
                size_before, since = size, time.monotonic()
            check_interruption()
            if time.monotonic() - since > limits.rule:
                return "hang"
            if time.monotonic() > limits.end:
                return "not-run"
            if output.stat().st_size > MOST_TEXT or size > _MOST_REPORT:
                return "floods-output"

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
                for reason, text in message["reasons"].items():
                    self.failed[interface, during, reason] = text
                self.results[interface] = message["results"]
            done = done or "end" in message
            self.again = self.again or "again" in message
        return interface, during, done
