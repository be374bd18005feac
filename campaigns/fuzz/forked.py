"""Readers of logs without their start: each forks from a process that has loaded its library.

A reader that crashes ends a process of its own all the same.
"""

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from unittest.mock import patch

from campaigns.fuzz.parser import Parse
from stickslip.logs import signals

_SERVER = """
import os, signal, sys, traceback
import scipy.io
from stickslip.logs import reader_process

for line in sys.stdin:
    timeout, module, *files = line.rstrip().split("\\t")
    if not (child := os.fork()):
        signal.alarm(int(timeout))
        for number, file in enumerate(files):
            os.dup2(os.open(file, os.O_RDONLY if number == 0 else os.O_WRONLY), number)
        sys.argv[1:], status = [module], 1
        try:
            reader_process.main()
            sys.stdout.flush()
            status = 0
        except BaseException:
            traceback.print_exc()
        os._exit(status)
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""


@cache
def _server() -> subprocess.Popen[str]:
    """Start the process; it ends with this one, which closes its standard input."""
    search = {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    return subprocess.Popen(
        [sys.executable, "-c", _SERVER],
        env=os.environ | search,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


@dataclass
class _Reader:
    """What `signals` needs of ``subprocess.Popen``."""

    module: str
    returncode: int = 0

    def communicate(self, data: bytes, timeout: float) -> tuple[bytes, bytes]:
        with tempfile.TemporaryDirectory() as folder:
            files = [Path(folder, name) for name in ("in", "out", "err")]
            for file in files:
                file.write_bytes(data if file.name == "in" else b"")
            server = _server()
            assert server.stdin is not None
            assert server.stdout is not None
            print(int(timeout), self.module, *files, sep="\t", file=server.stdin, flush=True)
            self.returncode = int(server.stdout.readline())
            return files[1].read_bytes(), files[2].read_bytes()


@contextmanager
def _forked(command: Sequence[str], **_: object) -> Iterator[_Reader]:
    yield _Reader(command[-1])


def forked(parse: Parse) -> Parse:
    """Let a parser that reads in a process of its own fork it."""

    def parsed(data: bytes, folder: Path) -> object:
        with patch.object(signals, "child_process", _forked):
            return parse(data, folder)

    return parsed if hasattr(os, "fork") else parse
