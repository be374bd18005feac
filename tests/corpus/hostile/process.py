"""A child process that may crash, hang, fork and flood, and what is left of it."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO

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
