"""What sets of results survive while they are written: killed processes, full disks, removal."""

import errno
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from stickslip.errors import ResultsError, UsageError
from stickslip.fmi.files import atomic_write
from stickslip.storage import locked, staged, verify

Files = Mapping[str, bytes]

OLD: Files = {
    "table.csv": b"old\n" * 2000,
    "learned.json": b"{}\n",
    "only_old.png": b"\x89PNG" * 9,
    "drives/a/learned.json": b'{"a": 1}\n',
}
NEW: Files = {
    "table.csv": b"new\n" * 3000,
    "learned.json": b'{"m": 5.5}\n',
    "only_new.svg": b"<svg/>",
    "drives/a/learned.json": b'{"a": 2}\n',
    "drives/b/learned.json": b'{"b": 2}\n',
}


def write(files: Files, folder: Path) -> None:
    """Write a set as commands do."""
    with staged(folder, {"name": "survival"}) as staging:
        for name, content in files.items():
            atomic_write(staging / name, content)


def plain(folder: Path) -> Files:
    """Return what a reader sees who knows of no hidden files and no manifest."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
        and not path.relative_to(folder).as_posix().startswith(".stickslip-")
        and path.name != "manifest.json"
    }


def holds(folder: Path, sets: Iterable[Files]) -> str:
    """Return ``at once`` or ``recovered`` for a folder that holds one of the sets.

    Raises
    ------
    RuntimeError
        When it holds none of them, or not as its manifest says, or something else is left.
    """
    sets = list(sets)
    found = "at once" if plain(folder) in sets else "recovered"
    verdict = verify(folder)
    if verdict.faults or plain(folder) not in sets:
        raise RuntimeError(f"{folder} holds neither set: {verdict}, {sorted(plain(folder))}")
    with locked(folder):
        pass
    if left := [path.name for path in folder.glob(".stickslip-*")]:
        raise RuntimeError(f"{folder}: left behind: {left}")
    return found


WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT
CHANGES = {"os.rename", "os.mkdir"}
"""Events that may need room on the disk, beside files opened to write and those synced."""
DELETIONS = {"os.remove", "os.rmdir"}


class _Fault:
    """Counts operations on files below a folder, and acts at the n-th and each after it."""

    folder, n, counted, deletions = "", 0, 0, True
    act: Callable[[], object]

    def __init__(self) -> None:
        sys.addaudithook(self._hear)
        sync = os.fsync
        os.fsync = lambda handle: (self.count(), sync(handle))[1]

    def _hear(self, event: str, arguments: tuple[Any, ...]) -> None:
        asked = event in CHANGES or (self.deletions and event in DELETIONS)
        asked = asked or (event == "open" and arguments[2] & WRITES)
        if self.folder and asked and os.fspath(arguments[0]).startswith(self.folder):
            self.count()

    def count(self) -> None:
        if self.folder:
            self.counted += 1
            if self.counted >= self.n:
                self.act()


_fault = cache(_Fault)


@contextmanager
def fault(
    folder: Path, act: Callable[[], object], n: int, *, deletions: bool = True
) -> Iterator[_Fault]:
    """Call ``act`` before the n-th operation in a folder and each after it.

    Parameters
    ----------
    deletions : whether they count
    """
    it = _fault()
    it.act, it.n, it.counted, it.deletions, it.folder = act, n, 0, deletions, str(folder)
    try:
        yield it
    finally:
        it.folder = ""


def die() -> None:
    """End this process as the system does that has no memory left."""
    os.kill(os.getpid(), 9)


def full() -> NoReturn:
    """Have no room on the disk."""
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def once(act: Callable[[], object]) -> Callable[[], object]:
    """Return what acts the first time only."""
    left = [act]
    return lambda: left.pop()() if left else None


Write = Callable[[Path], object]


def kill_at_each_operation(folder: Path, old: Files, new: Files) -> Counter[str]:
    """Kill a process before each of its operations on files while it replaces a set.

    Returns
    -------
    how often the folder held a whole set at once, and how often only after ``stickslip verify``
    """
    outcomes: Counter[str] = Counter()
    for n in count(1):
        shutil.rmtree(folder, ignore_errors=True)
        write(old, folder)
        child = os.fork()
        if not child:
            with fault(folder, die, n):
                write(new, folder)
            os._exit(0)
        _, status = os.waitpid(child, 0)
        if status == 0:
            if plain(folder) != new:
                raise RuntimeError(f"{folder}: not replaced by a process that was not killed")
            return outcomes
        if os.WTERMSIG(status) != signal.SIGKILL:
            raise RuntimeError(f"the process ended with {status}")
        outcomes[holds(folder, (old, new))] += 1
    raise AssertionError


def kill_at_random(
    folder: Path, writes: tuple[Write, Write], kills: int, seed: int = 0
) -> Counter[str]:
    """Kill processes at random moments while they replace one set by the other, and back.

    Returns
    -------
    how often the folder held the older set, the newer one, and one only after ``stickslip verify``
    """
    rng = np.random.default_rng(seed)
    sets, duration = [], 0.0
    for each in writes:
        begin = time.perf_counter()
        each(folder)
        duration = time.perf_counter() - begin
        sets.append(plain(folder))
    outcomes: Counter[str] = Counter()
    turn = 0
    while outcomes.total() < kills:
        older = plain(folder)
        turn = 1 - sets.index(older)
        child = os.fork()
        if not child:
            os.setpgid(0, 0)
            writes[turn](folder)
            os._exit(0)
        time.sleep(rng.uniform(0.0, duration))
        os.kill(child, signal.SIGKILL)
        if os.waitpid(child, 0)[1] == 0:
            continue  # it was faster
        found = holds(folder, sets)
        which = "the older" if plain(folder) == older else "the newer"
        outcomes[f"{which} set, {found}"] += 1
    return outcomes


EXPECTED = (OSError, ResultsError, UsageError)


def fill_at_each_operation(folder: Path, old: Files, new: Files, *, stays: bool) -> Counter[str]:
    """Let each thing asked of the file system fail for want of room; the disk may stay full."""
    outcomes: Counter[str] = Counter()
    for n in count(1):
        shutil.rmtree(folder, ignore_errors=True)
        write(old, folder)
        said = ""
        with fault(folder, full if stays else once(full), n, deletions=False) as asked:
            try:
                write(new, folder)
            except EXPECTED as error:
                said = str(error)
        if asked.counted < n:
            return outcomes
        if not said and plain(folder) != new:
            raise RuntimeError(f"{folder}: operation {n} failed, and nobody said so")
        left = [p.name for p in folder.glob(".stickslip-*") if p.name != ".stickslip-ready"]
        if left:
            raise RuntimeError(f"{folder}: operation {n} left {left} behind")
        outcomes[holds(folder, (old, new))] += 1
    raise AssertionError


@contextmanager
def small_disk(folder: Path, size: int) -> Iterator[Path]:
    """Mount a file system of some bytes.

    Raises
    ------
    OSError
        When this user may not.
    """
    folder.mkdir()
    options = ["-o", f"size={size}"]
    done = subprocess.run(
        ["/bin/mount", "-t", "tmpfs", *options, "tmpfs", str(folder)], capture_output=True
    )
    if done.returncode:
        folder.rmdir()
        raise OSError(done.returncode, "cannot mount a file system here", str(folder))
    try:
        yield folder
    finally:
        subprocess.run(["/bin/umount", str(folder)], check=True)
        folder.rmdir()


def fill_for_real(disk: Path, old: Files, new: Files, times: int) -> Counter[str]:
    """Write where there is ever less room; nothing but the older set may be left then."""
    outcomes: Counter[str] = Counter()
    write(old, disk / "results")
    room = sum(len(content) for content in new.values())
    for k in range(times):
        ballast = disk / "ballast"
        free = os.statvfs(disk).f_bavail * os.statvfs(disk).f_frsize
        ballast.write_bytes(b"\0" * max(0, free - room * k // times))
        try:
            write(new, disk / "results")
            outcomes["written"] += 1
        except EXPECTED as error:
            if "No space left" not in str(error):
                raise
            if plain(disk / "results") != old:
                raise RuntimeError(f"{disk}: {error}, and the older set is not there") from error
            if left := list((disk / "results").glob(".*")):
                raise RuntimeError(f"{disk}: left behind: {left}") from error
            outcomes["said that the disk is full, the older set intact"] += 1
        ballast.unlink()
        write(old, disk / "results")
    return outcomes


def remove_at_random(folder: Path, new: Files, times: int, seed: int = 0) -> Counter[str]:
    """Delete the folder while it is written: no half set is taken for a whole one."""
    rng = np.random.default_rng(seed)
    outcomes: Counter[str] = Counter()
    begin = time.perf_counter()
    write(new, folder)
    duration = time.perf_counter() - begin
    for _ in range(times):
        remover = threading.Timer(
            rng.uniform(0.0, 1.2 * duration), shutil.rmtree, (folder,), {"ignore_errors": True}
        )
        remover.start()
        try:
            write(new, folder)
            written = True
        except EXPECTED:
            written = False
        remover.join()
        if not written:
            outcomes["said in one line"] += 1
        elif not plain(folder):
            outcomes["removed when it was written"] += 1
        else:
            outcomes[_seen_by_verify(folder)] += 1
        shutil.rmtree(folder, ignore_errors=True)
    return outcomes


def _seen_by_verify(folder: Path) -> str:
    """Return what ``stickslip verify`` makes of a folder that was removed while it was written."""
    try:
        verdict = verify(folder)
    except ResultsError as complaint:
        if "manifest.json: there is none" not in str(complaint):
            raise
        return "verify says that there is no manifest"
    if set(verdict.faults.values()) - {"missing"}:
        raise RuntimeError(f"{folder}: {verdict}")
    return "verify names what is missing" if verdict.faults else "a whole set"
