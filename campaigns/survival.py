"""``python -m campaigns.survival``: what sets of results survive while they are written.

Processes are killed, and the disk is full. A set that is lost raises; else what was found is
printed as JSON, where "recovered" means only after ``stickslip verify``.
"""

import errno
import json
import os
import shutil
import signal
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any, NoReturn

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


def holds(folder: Path) -> str:
    """Return ``at once`` or ``recovered`` for a folder that holds one of the sets, and no more."""
    found = "at once" if plain(folder) in (OLD, NEW) else "recovered"
    verdict = verify(folder)
    if verdict.faults or plain(folder) not in (OLD, NEW):
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
    """Call ``act`` before the n-th operation in a folder, deletions too, and each after it."""
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


def kill_at_each_operation(folder: Path) -> Counter[str]:
    """Kill a process before each of its operations on files while it replaces a set."""
    outcomes: Counter[str] = Counter()
    for n in count(1):
        shutil.rmtree(folder, ignore_errors=True)
        write(OLD, folder)
        child = os.fork()
        if not child:
            with fault(folder, die, n):
                write(NEW, folder)
            os._exit(0)
        _, status = os.waitpid(child, 0)
        if status == 0:
            if plain(folder) != NEW:
                raise RuntimeError(f"{folder}: not replaced by a process that was not killed")
            return outcomes
        if os.WTERMSIG(status) != signal.SIGKILL:
            raise RuntimeError(f"the process ended with {status}")
        outcomes[holds(folder)] += 1
    raise AssertionError


EXPECTED = (OSError, ResultsError, UsageError)


def fill_at_each_operation(folder: Path, *, stays: bool) -> Counter[str]:
    """Let each thing asked of the file system fail for want of room; the disk may stay full."""
    outcomes: Counter[str] = Counter()
    for n in count(1):
        shutil.rmtree(folder, ignore_errors=True)
        write(OLD, folder)
        said = ""
        with fault(folder, full if stays else once(full), n, deletions=False) as asked:
            try:
                write(NEW, folder)
            except EXPECTED as error:
                said = str(error)
        if asked.counted < n:
            return outcomes
        if not said and plain(folder) != NEW:
            raise RuntimeError(f"{folder}: operation {n} failed, and nobody said so")
        left = [p.name for p in folder.glob(".stickslip-*") if p.name != ".stickslip-ready"]
        if left:
            raise RuntimeError(f"{folder}: operation {n} left {left} behind")
        outcomes[holds(folder)] += 1
    raise AssertionError


def main() -> None:
    """Try all, and print what was found."""
    os.fsync = lambda _: None  # only slows this: the machine is not switched off
    with tempfile.TemporaryDirectory(prefix="stickslip-") as name:
        folder = Path(name)
        found = {
            "killed": kill_at_each_operation(folder / "a"),
            "full once": fill_at_each_operation(folder / "b", stays=False),
            "full for good": fill_at_each_operation(folder / "c", stays=True),
        }
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
