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
from stickslip.fmi.process import sandbox
from stickslip.fmucheck import rules
from tests.corpus import fmu

REFUSED = {  # attempt -> how it is named, and the call; {0} is the victim's folder, {1} its process, {2} its terminal
    "read": ("read {0}/secret", "openat -100 ={0}/secret 0"),
    "write": ("write {0}/secret", "openat -100 ={0}/secret 0x401"),
    "create": ("write {0}/new", "openat -100 ={0}/new 0x41 0600"),
    "handle": ("read {0}/secret", "openat -100 ={0}/secret 0x200000"),
    "delete": ("delete {0}/secret", "unlinkat -100 ={0}/secret"),
    "folder": ("write {0}/new", "mkdirat -100 ={0}/new 0700"),
    "move": ("delete {0}/secret", "renameat2 -100 ={0}/secret -100 ={0}/other"),
    "take": ("delete {0}/secret", "renameat2 -100 ={0}/secret -100 =own"),
    "link": ("link {0}/secret", "linkat -100 ={0}/secret -100 =own"),
    "chmod": ("call fchmodat for {0}/secret", "fchmodat -100 ={0}/secret 0777"),
    "chmod_root": ("call fchmodat for /proc/self/root{0}/secret", "fchmodat -100 =/proc/self/root{0}/secret 0777"),
    "chmod_handle": ("call fchmodat for /proc/self/fd/", "fchmodat -100 handle 0644"),
    "fchmod": ("call fchmod for /etc/passwd", "fchmod foreign 0644"),
    "futimens": ("call utimensat for /etc/passwd", "utimensat foreign"),
    "flock": ("call flock for /etc/passwd", "flock foreign 5"),
    "lease": ("call fcntl 0x400", "fcntl foreign 1024 0"),
    "attributes": ("call ioctl 0x40086602", "ioctl foreign 0x40086602 zeros"),
    "limits": ("call prlimit64 for process {1}", "prlimit64 {1} 7 zeros 0"),
    "kill": ("send a signal to process {1}", "kill {1} 15"),
    "kill_all": ("send a signal to process -1", "kill -1 0"),
    "tgkill": ("send a signal to process {1}", "tgkill {1} {1} 15"),
    "priority": ("call setpriority for process {1}", "setpriority 0 {1} 7"),
    "priority_user": ("call setpriority for process 0", "setpriority 2 0 0"),
    "terminal": ("read /dev/pts/", "openat -100 ={2} 0x900"),
    "own_terminal": ("read /dev/tty", "openat -100 =/dev/tty 0"),
    "type": ("call ioctl 0x5412", "ioctl 0 0x5412 =x"),
    "shared_file": ("write /dev/shm/stickslip-attempt", "openat -100 =/dev/shm/stickslip-attempt 0x42 0600"),
    "datagrams": ("call socketpair", "socketpair 1 2 0 zeros"),
    "unix_socket": ("open a socket of other programs", "socket 1 1 0"),
    "internet": ("open a network connection", "socket 2 1 0"),
    "crypto": ("open a socket of family 38", "socket 38 5 0"),
    "io_uring": ("call io_uring_setup", "io_uring_setup 1 zeros"),
    "namespace": ("make a namespace", "clone 0x10000011"),
    "group": ("leave its group of processes", "setpgid 0 0"),
    "program": ("start the program /bin/true", "execve =/bin/true zeros zeros"),
    "not_dumped": ("call prctl 0x4", "prctl 4 0"),
    "unknown": ("call 1000", "1000"),
    **({"x32": ("call 1073741863", "1073741863"), "32_bits": ("call 20 of 32 bits", "")} if os.uname().machine == "x86_64" else {}),
    "sendto": ("call sendto", ""),
    "shared_memory": ("share more memory than it may take", ""),
    "other_threads": ("write {0}/new", ""),
    "threads": ("start more than 256 processes and threads", ""),
    "processes": ("start more than 256 processes and threads", ""),
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


def order(name: str, victim: Victim) -> str:
    """Return a line that asks for an attempt: its name, and the number and arguments of a call."""
    called, *words = REFUSED.get(name, ("", ""))[1].split() or [""]
    number = str(sandbox.numbers(os.uname().machine).get(called, called))
    line = " ".join([name, number, *words])
    return line.format(victim.folder, victim.process, os.ttyname(victim.screen))


def write(path: Path, binary: bytes, victim: Victim, names: list[str]) -> Path:
    """Write an FMU that tries some, one after the other."""
    interface = {"CoSimulation": 'canHandleVariableCommunicationStepSize="true"'}
    description = fmu.describe("attempts", 2, [fmu.Variable("u", "input", 0.0)], interface)
    orders = "\n".join([str(victim.folder), *(order(name, victim) for name in names)])
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
        expected = [said.format(victim.folder, victim.process) for said, _ in REFUSED.values()]
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
