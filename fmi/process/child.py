"""Child processes: started in a session of their own, limited, and ended with all they started."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from io import TextIOWrapper
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stickslip.fmi.process.interruption import held

if TYPE_CHECKING:  # the table of system calls is for parents only
    from stickslip.fmi.process.guard import Guard
    from stickslip.fmi.process.sandbox import Permissions


@contextmanager
def child_process(command: Sequence[str], **options: Any) -> Iterator[subprocess.Popen[bytes]]:
    """Start a process in its own session; at the end of the block all that it started is gone."""
    process = None
    try:
        with held():
            process = subprocess.Popen(command, start_new_session=True, **options)
        yield process
    finally:
        if process is not None:
            with held():
                kill(process)
                process.wait()
                close_pipes(process)


def start_python(
    arguments: Sequence[str],
    room: Path,
    guard: "Guard | None",
    allow: "Permissions",
    variables: Mapping[str, str],
    files: Sequence[int] = (),
) -> subprocess.Popen[bytes]:
    """Start Python in a session of its own, for code that is not trusted; all streams are pipes.

    It may write below ``room``, has ``variables`` in its environment and inherits the descriptors
    ``files``. Without a guard it has the environment and the folder of this process. OSError when
    it cannot be started.
    """
    search = os.pathsep.join(str(Path(path).absolute()) for path in sys.path if path)
    environment = dict(os.environ)
    if guard:
        files = (*files, guard.file)
        environment = allow.environment() | {"TMPDIR": str(room)}
    try:
        return subprocess.Popen(
            [sys.executable, *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            bufsize=0,
            pass_fds=files,
            start_new_session=True,
            cwd=room if guard and not allow.folders else None,
            env=environment | {"PYTHONPATH": search} | dict(variables),
        )
    finally:
        if guard:
            guard.close_file()


def kill(process: subprocess.Popen[bytes]) -> None:
    """End a process, which may be gone already, and all others of its session."""
    if sys.platform == "win32":
        process.kill()
    else:
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)


def close_pipes(process: subprocess.Popen[bytes]) -> None:
    """Close the ends of its pipes that this process has."""
    for pipe in (process.stdin, process.stdout, process.stderr):
        if pipe is not None:
            pipe.close()


def limit(memory: float) -> None:
    """Limit memory and files (MB), stack and core files on Linux, core files also on macOS."""
    if sys.platform == "win32":
        return
    import resource

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if sys.platform == "linux":
        _, most = resource.getrlimit(resource.RLIMIT_STACK)
        stack = 2**26 if most == resource.RLIM_INFINITY else min(2**26, most)
        resource.setrlimit(resource.RLIMIT_STACK, (stack, most))
        status = Path("/proc/self/status").read_text()
        used = 1024 * int(status.split("VmData:")[1].split()[0])
        most_data = used + int(memory * 1e6)
        resource.setrlimit(resource.RLIMIT_DATA, (most_data, most_data))
        _, most = resource.getrlimit(resource.RLIMIT_FSIZE)
        size = int(memory * 1e6) if most == resource.RLIM_INFINITY else most
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


def open_standard_streams() -> None:
    """Open the null device in the place of each standard stream that is closed.

    A file that is opened later would else get the stream's number, and what is printed or read by
    that number would go into it or come out of it. Characters that the encoding of an output lacks
    are printed by their number, such as U+00E4, as escapes.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            opened = os.open(os.devnull, os.O_RDWR)
            if opened != number:
                os.dup2(opened, number)
                os.close(opened)
            os.set_inheritable(number, True)
        if getattr(sys, name) is None:
            mode = "w" if number else "r"
            setattr(sys, name, open(number, mode, encoding="utf-8", closefd=False))  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
