"""What FMUs try that the sandbox refuses, and the traces that it would leave.

``python -m tests.corpus.hostile.attempts LIBRARY`` tries all in one FMU and prints what came of it
as JSON.
"""

import fcntl
import json
import os
import pty
import resource
import select
import signal
import socket
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from stickslip import fmucheck
from stickslip.fmucheck import rules
from tests.corpus import fmu

REFUSED = {  # attempt -> how it is named; {0} stands for the folder of the victim, {1} for its process
    "read": "read {0}/secret",
    "write": "write {0}/secret",
    "create": "write {0}/new",
    "handle": "read {0}/secret",
    "delete": "delete {0}/secret",
    "folder": "write {0}/new",
    "move": "delete {0}/secret",
    "take": "delete {0}/secret",
    "link": "link {0}/secret",
    "chmod": "call fchmodat for {0}/secret",
    "chmod_root": "call fchmodat for /proc/self/root{0}/secret",
    "chmod_handle": "call fchmodat for /proc/self/fd/",
    "fchmod": "call fchmod for /etc/passwd",
    "futimens": "call utimensat for /etc/passwd",
    "flock": "call flock for /etc/passwd",
    "lease": "call fcntl 0x400",
    "attributes": "call ioctl 0x40086602",
    "limits": "call prlimit64 for process {1}",
    "kill": "send a signal to process {1}",
    "kill_all": "send a signal to process -1",
    "tgkill": "send a signal to process {1}",
    "priority": "call setpriority for process {1}",
    "priority_user": "call setpriority for process 0",
    "terminal": "read /dev/pts/",
    "own_terminal": "read /dev/tty",
    "type": "call ioctl 0x5412",
    "shared_file": "write /dev/shm/stickslip-attempt",
    "datagrams": "call socketpair",
    "unix_socket": "open a socket of other programs",
    "internet": "open a network connection",
    "crypto": "open a socket of family 38",
    "io_uring": "call io_uring_setup",
    "namespace": "make a namespace",
    "group": "leave its group of processes",
    "program": "start the program /bin/true",
    "not_dumped": "call prctl 0x4",
    "unknown": "call 1000",
    **({"x32": "call 1073741863", "32_bits": "call 20 of 32 bits"} if os.uname().machine == "x86_64" else {}),
    "sendto": "call sendto",
    "shared_memory": "share more memory than it may take",
    "other_threads": "write {0}/new",
    "threads": "start more than 256 processes and threads",
    "processes": "start more than 256 processes and threads",
}  # fmt: skip
SILENT = ("environment", "raised_limits", "own_files")
"""What is not worth a word: it has no effect, or is allowed and works."""
MARK = "stickslip-attempt"


def library() -> Path:
    """Return the compiled attempts.c."""
    source = Path(__file__).with_suffix(".c")
    return fmu.library(
        "attempts", source, flags=("-Wno-unused-parameter", "-lpthread"), versions=(2,)
    )


class Victim:
    """A process, its files, its terminal and its socket, all of this user."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.secret = folder / "secret"
        self.secret.write_text("top secret")
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.socket.bind(str(folder / "other"))
        self.keys, self.screen = pty.openpty()
        os.write(self.keys, b"a password\n")
        select.select([self.screen], [], [], 10.0)  # a terminal passes it on some time later
        self.process = os.fork()
        if self.process == 0:
            signal.pause()
            os._exit(0)

    def state(self) -> dict[str, Any]:
        """Return all that an FMU must not change."""
        file = self.secret.stat()
        locked = self.secret.open()
        fcntl.flock(locked, fcntl.LOCK_EX | fcntl.LOCK_NB)
        locked.close()
        sent = b""
        with suppress(BlockingIOError):
            sent = self.socket.recv(99, socket.MSG_DONTWAIT)
        ended, _ = os.waitpid(self.process, os.WNOHANG)
        typed = bytearray(4)
        fcntl.ioctl(self.screen, 0x541B, typed)
        processes = {
            who: (
                os.getpriority(os.PRIO_PROCESS, process),
                resource.prlimit(process, resource.RLIMIT_NOFILE),
            )
            for who, process in (("victim", self.process), ("parent", os.getpid()))
        }
        return {
            "file": (file.st_mode, file.st_uid, file.st_mtime_ns, file.st_nlink, file.st_size),
            "content": self.secret.read_text(),
            "folder": sorted(path.name for path in self.folder.iterdir()),
            "ended": ended,
            "sent": sent,
            "typed": bytes(typed),
            "processes": processes,
            "shared": [str(path) for path in Path("/dev/shm").glob(f"*{MARK}*")],  # noqa: S108
        }

    def end(self) -> None:
        with suppress(OSError):
            os.kill(self.process, signal.SIGKILL)
            os.waitpid(self.process, 0)
        self.socket.close()
        os.close(self.keys)
        os.close(self.screen)


@contextmanager
def a_victim() -> Iterator[tuple[Victim, Path]]:
    with tempfile.TemporaryDirectory() as folder:
        for name in ("victim", "room"):
            (Path(folder) / name).mkdir()
        victim = Victim(Path(folder) / "victim")
        try:
            yield victim, Path(folder) / "room"
        finally:
            victim.end()


def write(path: Path, binary: bytes, victim: Victim, names: list[str]) -> Path:
    """Write an FMU that tries some, one after the other."""
    interface = {"CoSimulation": 'canHandleVariableCommunicationStepSize="true"'}
    description = fmu.describe("attempts", 2, [fmu.Variable("u", "input", 0.0)], interface)
    terminal = os.ttyname(victim.screen)
    orders = f"{victim.process} {victim.folder} {terminal}\n" + "\n".join(names)
    files = {"resources/behaviour.txt": orders.encode(), fmu.place("attempts", 2): binary}
    return fmu.pack(path, description, files)


def checked(binary: bytes) -> dict[str, list[str]]:
    """Return what `check` names of an FMU that tries all, what has worked, and what has changed."""
    with a_victim() as (victim, room):
        names = [*REFUSED, *SILENT]
        path = write(room / "attempts.fmu", binary, victim, names)
        rules._LISTED = 1000  # all of one rule
        before = victim.state()
        report = fmucheck.check(path)
        after = victim.state()
        expected = [REFUSED[name].format(victim.folder, victim.process) for name in REFUSED]
    named = [place for f in report if f.rule == "reaches-outside" for place in (f.place, *f.others)]
    return {
        "lacking": [one for one in expected if not any(n.startswith(one) for n in named)],
        "beside": [one for one in named if not one.startswith(tuple(expected))],
        "printed": [str(f) for f in report if f.rule == "prints"],
        "changed": [what for what in before if before[what] != after[what]],
    }


if __name__ == "__main__":
    tempfile.tempdir = "/var/tmp"  # noqa: S108 - outside what other tests watch
    os.environ["SECRET_TOKEN"] = "top secret"  # noqa: S105 - of the victim
    print(json.dumps(checked(Path(sys.argv[1]).read_bytes())))
