"""What FMPy and stickslip do with a case, in processes that may crash, hang, fork and flood."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import warnings
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import IO

from tests.corpus.hostile import python
from tests.corpus.hostile.case import Case

KEPT = 1 << 16
"""Bytes of output that are kept; the rest is read and forgotten."""


@dataclass(frozen=True)
class Ended:
    """How a process ended.

    Parameters
    ----------
    status : as ``subprocess`` has it; None if it was still running at its time limit
    output : what it wrote to standard error, the beginning
    silent : whether it wrote nothing at all
    left : names of what it left in its folder for temporary files
    """

    status: int | None
    output: str
    silent: bool
    left: tuple[str, ...]


def run(
    command: Sequence[str], folder: Path, temporary: Path, timeout: float, **variables: str
) -> Ended:
    """Run a command in a folder with a folder for temporary files; no process of it stays."""
    environment = os.environ | {"TMPDIR": str(temporary)} | variables
    process = subprocess.Popen(
        command,
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )
    kept: dict[str, bytes] = {}
    streams = {"out": process.stdout, "err": process.stderr}
    readers = [
        threading.Thread(target=_drain, args=(name, stream, kept), daemon=True)
        for name, stream in streams.items()
    ]
    for reader in readers:
        reader.start()
    status: int | None = None
    with suppress(subprocess.TimeoutExpired):
        status = process.wait(timeout)
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)  # and all that it forked
    process.wait()
    for reader in readers:
        reader.join(5.0)
    left = tuple(sorted(path.name for path in temporary.iterdir()))
    output = kept.get("err", b"").decode(errors="replace")
    return Ended(status, output, not any(kept.values()), left)


def _drain(name: str, stream: IO[bytes], kept: dict[str, bytes]) -> None:
    with stream, suppress(OSError, ValueError):
        while block := os.read(stream.fileno(), KEPT):
            so_far = kept.get(name, b"")
            if len(so_far) < KEPT:
                kept[name] = so_far + block


PATIENCE = 10.0
"""How long FMPy may take for one file [s]."""
OURS = 120.0
LONGEST = 150
"""Characters of a line that the table shows."""

NONE = "no counterpart"
KINDS = ("crashes", "hangs", "ends silently", "runs", "Python error", "own message", NONE)


@dataclass(frozen=True)
class Verdict:
    """What became of a case: one of `KINDS`, or ``one line`` and ``else`` for us, and words."""

    kind: str
    words: str


def verdicts_of(case: Case, cache: Path) -> tuple[Verdict, Verdict]:
    """Return what FMPy and what stickslip do with a case."""
    with tempfile.TemporaryDirectory(prefix="hostile-") as name:
        folder = Path(name, "fed")
        folder.mkdir()
        with warnings.catch_warnings(action="ignore"):
            arguments = case.make(folder)
        copy = Path(name, "copy")
        shutil.copytree(folder, copy, symlinks=True, ignore=_pipes)
        theirs = fmpy(arguments, copy, Path(name))
        return theirs, stickslip(case, folder, Path(name), cache)


def fmpy(arguments: Sequence[str], folder: Path, room: Path) -> Verdict:
    """Feed FMPy the FMU or package of a command, with the input, times and values that it has."""
    job = _job(arguments, folder)
    if job is None:
        return Verdict(NONE, NONE)
    path, temporary = room / "fmpy.json", room / "fmpy"
    path.write_text(json.dumps(job), encoding="utf-8")
    temporary.mkdir()
    command = [sys.executable, "-P", str(Path(__file__).with_name("fed_to_fmpy.py")), str(path)]
    ended = run(command, folder, temporary, PATIENCE)
    kind, words = _what_fmpy_did(ended, path.with_suffix(".answer"), room)
    return Verdict(kind, words + "; leaves a temporary folder" * bool(ended.left))


def stickslip(case: Case, folder: Path, room: Path, cache: Path) -> Verdict:
    """Feed a case to ourselves."""
    temporary = room / "stickslip"
    temporary.mkdir()
    words = ["-P", python.__file__, case.code]
    command = [
        sys.executable,
        *(words if case.code else ["-m", "stickslip", *case.command.split()]),
    ]
    ended = run(command, folder, temporary, OURS, STICKSLIP_CACHE=str(cache))
    lines = ended.output.splitlines()
    said = neutral(lines[-1].removeprefix("stickslip: ") if lines else "nothing", room)
    if ended.status in {1, 2} and len(lines) == 1 and not ended.left:
        return Verdict("one line", said)
    return Verdict("else", f"status {ended.status}, {len(lines)} lines, left {ended.left}: {said}")


def neutral(text: str, room: Path, longest: int = LONGEST) -> str:
    """Return one short line without this machine's paths and without what Markdown reads."""
    text = re.sub(rf"{re.escape(str(room))}/(fed|copy)/?", "", text)
    for root in (str(room), tempfile.gettempdir(), sys.prefix, str(Path.home())):
        text = re.sub(rf"(?<!\w){re.escape(root)}(/[^\s/'\":;,()]+)*/?", _last, text)
    text = re.sub(r"(.)\1{20,}", r"\1\1\1...", text)
    text = re.sub(r"\b[0-9a-f]{32,}\b", "HASH", text)
    text = re.sub(r"\b127\.0\.0\.1:\d+", "127.0.0.1:PORT", text)
    text = re.sub(r"\binproc://[\d./]+", "inproc://ADDRESS", text)
    text = re.sub(r"\bprocess \d+", "process PID", text)
    text = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    if len(text) > longest:
        text = f"{text[: longest - 4]} ..."
    return re.sub(r"([\\|`*_<>\[\]])", r"\\\1", text)


def _last(path: re.Match[str]) -> str:
    return path[0].rstrip("/").rpartition("/")[2]


def _what_fmpy_did(ended: Ended, answer: Path, room: Path) -> tuple[str, str]:
    if ended.status is None:
        return "hangs", f"hangs (over {PATIENCE:g} s)"
    if ended.status < 0:
        return "crashes", f"crashes ({signal.Signals(-ended.status).name})"
    if not answer.exists():
        silent = " and no message" if ended.silent else ""
        return "ends silently", f"ends with status {ended.status}{silent}"
    error = json.loads(answer.read_text(encoding="utf-8"))
    if error is None:
        return "runs", "runs, no complaint"
    kind = "own message" if error["meant"] else "Python error"
    return kind, f"{error['type']}: {neutral(error['message'], room, 80)}"


def _job(arguments: Sequence[str], folder: Path) -> dict[str, object] | None:
    """Return what FMPy is to do, None if it has nothing of the kind."""
    files = [a for a in arguments if a.endswith((".fmu", ".ssp")) and (folder / a).exists()]
    if not files:
        return None
    follows = dict(pairwise(arguments))
    values = (a.partition("=") for a in arguments if "=" in a and not a.startswith("-"))
    return {
        "file": files[0],
        "input": follows.get("--input"),
        "stop_time": _number(follows.get("--stop")),
        "step_size": _number(follows.get("--step")),
        "start_values": {name.rpartition(".")[2]: value for name, _, value in values},
    }


def _number(text: str | None) -> float | None:
    try:
        return None if text is None else float(text)
    except ValueError:
        return None


def _pipes(folder: str, names: Sequence[str]) -> set[str]:
    """Return what cannot be copied: FMPy is fed none of it."""
    return {n for n in names if not (p := Path(folder, n)).is_symlink() and p.is_fifo()}
