"""What takes long runs in a process of its own, which tells how far it is."""

from __future__ import annotations

import logging
import multiprocessing
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from logging.handlers import QueueHandler
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from threading import Thread
from typing import Any

import stickslip as ss

Lines = list[str]
FAULTS = (ss.Fault, OSError, MemoryError)  # that a user can cause
RATE = 0.1  # least time between two reports of steps [s]
RUNNING = ".running"  # ends the name of a file that is beside the results of a job while it runs


def stamp(seconds: float | None = None) -> str:
    """Return a time, else the present one, as it is shown."""
    return time.strftime("%Y-%m-%d %H:%M", time.localtime(seconds))


class Told(ss.Progress):
    """Sends progress through a connection."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._search: object = None
        self._sent, self._last = 0, 0.0

    def put_nowait(self, record: logging.LogRecord) -> None:
        """Tell a warning, as the queue of a handler."""
        self.tell(line=f"warning: {record.getMessage()}")

    def tell(self, **news: object) -> None:
        """Send what is new of a job."""
        self._connection.send(news)

    def stage(self, name: str) -> None:
        """Tell that a stage begins."""
        self.tell(stage=name)

    def findings(self, findings: Iterable[object]) -> None:
        """Tell findings of a log."""
        for finding in findings:
            self.tell(line=str(finding))

    def move(self, done: int, of: int | None, unit: str = "step", remark: str = "") -> None:
        """Tell how much of a stage of several steps is done, at most ten times a second."""
        now = time.monotonic()
        if of not in (0, 1) and (now - self._last > RATE or done == of):
            self._last = now
            count = f"{done} of {of}" if of else f"{done}"
            self.tell(done=(of and done / of, f"{count} {unit}s", remark))

    def generation(self, algorithm: ss.ga.Optimiser, scale: Any = None) -> None:
        """Tell the candidates of a search since the last ones, in SI units."""
        if algorithm is not self._search:
            self._search, self._sent = algorithm, 0
            self.tell(search=list(algorithm.names))
        rows = algorithm.history.iloc[self._sent :][[*algorithm.names, "cost"]]
        self._sent += len(rows)
        if scale:
            rows = rows / [*map(scale.of, algorithm.names), scale.of("F_c") ** 2]
        self.tell(candidates=rows)
        cost = f"best cost {algorithm.best.cost / (scale.of('F_c') ** 2 if scale else 1.0):.3g}"
        self.move(algorithm.evaluations, algorithm.limits.evaluations, "candidate", cost)


def learn(
    told: Told,
    folder: Path,
    logs: list[str],
    description: ss.Description,
    *,
    force: bool,
    **settings: Any,
) -> Lines:
    """Learn the logs of a drive together and write what is found."""
    learned = ss.learn(logs, description, progress=told, **settings)
    told.stage("writing the results")
    warnings = [f"warning: {line}" for line in learned.warnings]
    return [*ss.write_learned(learned, folder, force=force).sentences, *warnings]


def tune(told: Told, folder: Path, source: Path, cost: str | None, **settings: Any) -> Lines:
    """Tune the loop of a learned drive, or a system of FMUs for a cost, and write it."""
    found: Any = ss.tune(source, cost=cost, progress=told, **settings)
    if cost is None:
        ss.write_tuned(found, folder)
        return [found.sentence]
    ss.write_optimised(found, source, Path(cost), folder)
    return [repr(found)]


def arena(told: Told, folder: Path, **settings: Any) -> Lines:
    """Compare compensators on drives and write the page."""

    def done(count: int, of: int, cell: str) -> None:
        told.tell(line=f"{count} of {of}: {cell}")
        told.move(count, of, "cell")

    ss.arena(folder=folder, progress=done, **settings).write(folder)
    return []


def message_of(fault: BaseException) -> str:
    """Return the line that the command would print for an error."""
    text = str(fault)
    if isinstance(fault, OSError) and fault.filename:
        text = f"{fault.filename}: {fault.strerror}"
    return " ".join(text.split()) or type(fault).__name__


def _work(connection: Connection, task: Callable[..., Lines], given: Mapping[str, Any]) -> None:
    """Run a task in this process, which ends when nobody receives its progress any more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the server ends its jobs
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with Told(connection) as told, suppress(BrokenPipeError):
        queue: Any = told
        logging.getLogger("stickslip").addHandler(QueueHandler(queue))
        try:
            told.tell(result=task(told, **given))
        except FAULTS as fault:
            told.tell(error=message_of(fault))
        except KeyboardInterrupt:
            told.tell(error="stopped")


@dataclass
class Job:
    """A task that runs or has run, and what it has told."""

    name: str
    of: str = ""  # the files that it takes
    since: str = field(default_factory=stamp)
    stages: Lines = field(default_factory=lambda: ["loading"])
    lines: Lines = field(default_factory=list)  # findings, warnings, what was done
    done: tuple[float | None, str, str] = (None, "", "")  # share of the stage, steps, remark
    names: list[str] = field(default_factory=list)  # of the parameters of the present search
    candidates: list[Any] = field(default_factory=list)  # tables of them, by generation
    result: Lines | None = None
    error: str = ""
    ended: bool = False
    version: int = 0  # counts what is told
    process: BaseProcess | None = None
    mark: Path | None = None  # a file that is there while it runs

    @classmethod
    def begin(cls, name: str, of: str, task: Callable[..., Lines], **given: Any) -> Job:
        """Start a task on some files that writes to a folder."""
        mark = given["folder"].with_name(name + RUNNING)
        mark.write_text(of, encoding="utf-8")
        context = multiprocessing.get_context("spawn")
        receiver, sender = context.Pipe(duplex=False)
        process = context.Process(target=_work, args=(sender, task, given))
        process.start()
        sender.close()
        job = cls(name, of, process=process, mark=mark)
        Thread(target=job._follow, args=(receiver, process), daemon=True).start()
        return job

    def _follow(self, receiver: Connection, process: BaseProcess) -> None:
        with suppress(EOFError, OSError):
            while True:
                self._take(**receiver.recv())
        process.join()
        if self.result is None and not self.error:
            self.error = f"the process ended with status {process.exitcode}; see the terminal"
        if self.mark:
            self.mark.unlink(missing_ok=True)
        self.ended = True
        self.version += 1

    def _take(self, **news: Any) -> None:
        for name, value in news.items():
            if name == "stage":
                self.stages.append(value)
                self.done = Job.done
            elif name == "line":
                self.lines.append(value)
            elif name == "search":
                self.names, self.candidates = value, []
            elif name == "candidates":
                self.candidates.append(value)
            else:
                setattr(self, name, value)
        self.version += 1

    def stop(self) -> None:
        """End the process."""
        if self.process is not None and not self.ended:
            self.process.terminate()


def export(learned: Path, part: str, form: str, folder: Path) -> list[Path]:
    """Export a part as the command does, and return the files; raise RuntimeError with its line."""
    words = ["export", part, "--parameters", str(learned), "--as", form, "--out", str(folder)]
    done = subprocess.run(
        [sys.executable, "-m", "stickslip", *words], capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise RuntimeError(done.stderr.strip().splitlines()[-1].removeprefix("stickslip: "))
    return sorted(path for path in folder.rglob("*") if path.is_file())
