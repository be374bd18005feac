"""Disks that are full and folders that vanish."""

from __future__ import annotations

import os
import shutil
import subprocess
import threading
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path

import numpy as np

from stickslip.errors import ResultsError, UsageError
from stickslip.results.folder import verify
from tests.corpus.survival.faults import fault, full, once
from tests.corpus.survival.sets import Files, holds, plain, write

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
        elif any(said != "missing" for said in verify(folder).faults.values()):
            raise RuntimeError(f"{folder}: {verify(folder)}")
        elif verify(folder).faults:
            outcomes["being removed when it was written; verify names what is missing"] += 1
        else:
            outcomes["a whole set"] += 1
        shutil.rmtree(folder, ignore_errors=True)
    return outcomes
