"""The parent's part of the sandbox: decides what a child may not decide, refuses and names it."""

import ctypes
import errno
import os
import re
import select
import signal
import socket
import struct
import sys
import threading
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import cache
from pathlib import Path
from stat import S_ISREG
from typing import Any, Self

from stickslip.fmi.process import sandbox
from stickslip.fmi.process.permitted import HUGE, program

_MOST_AT_ONCE = 256  # processes and threads
_MOST_NOTED = 200
_LOOK = 0.25  # s between two looks at memory and files; a disk takes some 0.3 GB meanwhile
_LONGEST = 200  # characters of a path in a message
_RECEIVE, _SEND, _CONTINUE = 0xC0502100, 0xC0182101, 1  # linux/seccomp.h
_NOTE, _ANSWER = struct.Struct("<QIIiIQ6Q"), struct.Struct("<QqiI")
_GOES_ON, _DONE = -1, 0  # to the kernel; as if it had worked
_HERE = -100  # AT_FDCWD
_FAMILIES = {1: "a socket of other programs", 2: "a network connection", 10: "a network connection"}
_ROUTES = (16, 0)  # a netlink socket
_LOCKS = (6, 7, 37, 38)  # of fcntl
_PATHS = {  # call -> places of the folder, if any, and the path among its arguments, and the verb
    **dict.fromkeys(("creat", "mkdir"), ((None, 0, "write"),)),
    **dict.fromkeys(("unlink", "rmdir"), ((None, 0, "delete"),)),
    **dict.fromkeys(("renameat", "renameat2"), ((0, 1, "delete"), (2, 3, "write"))),
    "rename": ((None, 0, "delete"), (None, 1, "write")),
    "unlinkat": ((0, 1, "delete"),),
    "mkdirat": ((0, 1, "write"),),
    "link": ((None, 0, "link"), (None, 1, "write")),
    "linkat": ((0, 1, "link"), (2, 3, "write")),
    "open": ((None, 0, ""),),
    "openat": ((0, 1, ""),),
    "openat2": ((0, 1, ""),),
}
_ATTRIBUTES = {  # the same
    **dict.fromkeys(("chmod", "utime", "utimes"), (None, 0)),
    **dict.fromkeys(("fchmodat", "fchmodat2", "futimesat", "utimensat"), (0, 1)),
    **dict.fromkeys(("fchmod", "flock", "fcntl"), (0, None)),
}
_OF_A_PROCESS = {  # call -> place of its number among the arguments
    **dict.fromkeys(("sched_setaffinity", "sched_setscheduler", "sched_setparam"), 0),
    **dict.fromkeys(("sched_setattr", "prlimit64"), 0),
    "setpriority": 1,
}
_LEAVES = ("setsid", "setpgid")
_SIGNALS = ("kill", "tkill", "tgkill", "rt_sigqueueinfo", "rt_tgsigqueueinfo")
_STARTS = ("clone", "fork", "vfork")
_NAMESPACES, _THREAD = 0x7E020080, 0x10000  # flags of clone
_VALUES = {"fcntl": 1, "ioctl": 1, "prctl": 0}  # place of what is to be done


class Guard:
    """Refuses and notes what a child in the sandbox tries.

    ``readable`` and ``writable`` are paths, with all below them, ``memory`` the MB that the child
    may share between its processes; ``where`` returns what it is doing, for the notes. It inherits
    the descriptor ``file``, which `close_file` closes after it has started. ``tried`` is what was
    refused, such as ``("a: fmi2DoStep", "read /root/x")``, ``exhausted`` whether memory was.
    """

    def __init__(
        self,
        readable: Iterable[str],
        writable: Iterable[str],
        allow: sandbox.Permissions,
        memory: float,
        where: Callable[[], str] = str,
    ) -> None:
        import fcntl  # not on Windows

        self._readable, self._writable = list(readable), [*writable, *allow.folders]
        self._rooms, self._most, self._shared = list(writable), int(1e6 * memory), 0
        self._words, self._where = allow.words, where
        self.tried: list[tuple[str, str]] = []
        self._session, self._forked, self._at_most, self.exhausted = 0, False, 1, False
        self._at_start, self._looked = 0, 0.0
        ours, theirs = socket.socketpair()
        with theirs:  # the child needs no number of a standard stream
            self.file = fcntl.fcntl(theirs.fileno(), fcntl.F_DUPFD_CLOEXEC, 3)
        self._is_open = True
        self._names: dict[int, str] = {}
        self._thread = threading.Thread(target=self._serve, args=(ours,), daemon=True)
        self._thread.start()

    @classmethod
    def of_python(cls, packages: Iterable[str], readable: Iterable[str], *further: Any) -> Self:
        """Return the guard of a child that runs Python and may import what is in ``packages``."""
        paths = [Path(path) for name in packages for path in sys.modules[name].__path__]
        return cls([*sandbox.interpreter_folders(paths), *readable], *further)

    def entry(self) -> dict[str, Any]:
        """Return the arguments of ``sandbox.enter``; the child can have been started before."""
        readable, writable = [*sandbox.system_paths(), *self._readable], self._writable
        self._writable = [*map(os.path.realpath, writable), "/dev/null"]
        kept = map(os.path.realpath, self._readable)
        self._readable = [*kept, *sandbox.system_paths(), *self._writable]
        paths = {"readable": readable, "writable": writable}
        code, seccomp = _code(self._words), sandbox.numbers()["seccomp"]
        return paths | {"allow": self._words, "file": self.file, "code": code, "seccomp": seccomp}

    def close_file(self) -> None:
        """Close what the child has inherited."""
        if self._is_open:
            os.close(self.file)
            self._is_open = False

    def end(self, patience: float) -> None:
        """Wait, for a time (s), until the guard of a child that is gone has ended."""
        self._thread.join(patience)
        self._where = str  # lets go of what it asked

    def _serve(self, channel: socket.socket) -> None:
        """Wait for the child to enter; answer it until it is gone."""
        with channel:
            _, files, _, _ = socket.recv_fds(channel, 1, 1)
        if not files:  # it has not entered
            return
        self._names = {number: name for name, number in sandbox.numbers().items()}
        ioctl = ctypes.CDLL(None, use_errno=True).ioctl
        poll = select.poll()
        poll.register(files[0], select.POLLIN)
        note = ctypes.create_string_buffer(_NOTE.size)
        here = sandbox.processor()
        try:
            while True:
                events = poll.poll(1e3 * _LOOK)
                self._look()
                if not events:
                    continue
                if not all(event & select.POLLIN for _, event in events):
                    break
                ctypes.memset(note, 0, _NOTE.size)
                if ioctl(files[0], ctypes.c_ulong(_RECEIVE), note) < 0:
                    continue  # the caller was killed meanwhile
                number, process, _, call, kind, _, *arguments = _NOTE.unpack(note.raw)
                name = self._names.get(call, f"{call}") if kind == here else f"{call} of 32 bits"
                try:
                    error = self._decide(process, name, arguments)
                except (OSError, ValueError):  # the caller is gone, or it gave nonsense
                    error = errno.EPERM
                goes_on = error == _GOES_ON
                answer = _ANSWER.pack(number, 0, 0 if goes_on else -error, _CONTINUE * goes_on)
                ioctl(files[0], ctypes.c_ulong(_SEND), answer)
        finally:
            os.close(files[0])

    def _decide(self, process: int, call: str, arguments: list[int]) -> int:
        """Return the error that a call gets, _GOES_ON or _DONE."""
        if not self._session:
            self._session = os.getsid(process)
            self._at_start = 1024 * int(_status(self._session, "RssAnon"))
        if call in _PATHS:
            return self._at_path(process, call, arguments)
        if call in _STARTS:
            return self._start(arguments[0] if call == "clone" else 0)
        if call in _SIGNALS:
            target = ctypes.c_int(arguments[0]).value
            if self._is_own(target) or -target == self._session:
                return _GOES_ON
            return self._refuse(f"send a signal to process {target}")
        if call in _OF_A_PROCESS:
            target = ctypes.c_int(arguments[_OF_A_PROCESS[call]]).value
            if self._is_own(target) and (call != "setpriority" or not arguments[0]):
                return _GOES_ON
            return self._refuse(f"call {call} for process {target}")
        if call in _ATTRIBUTES and (call != "fcntl" or arguments[1] in _LOCKS):
            path = self._path(process, *_ATTRIBUTES[call], arguments)
            if sandbox.is_below(os.path.realpath(path), self._writable):
                return _DONE
            return self._refuse(f"call {call} for {path}", errno.EACCES)
        if call == "mmap" and not arguments[3] & HUGE:
            if self._shared + arguments[1] <= self._most:
                self._shared += arguments[1]
                return _GOES_ON
            self.exhausted = True
            return self._refuse("share more memory than it may take", errno.ENOMEM)
        if call == "socket":
            if sandbox.NETWORK in self._words and (
                arguments[0] in (2, 10) or (arguments[0], arguments[2]) == _ROUTES
            ):
                return _GOES_ON
            family = _FAMILIES.get(arguments[0], f"a socket of family {arguments[0]}")
            return self._refuse(f"open {family}", errno.EACCES)
        if call in ("execve", "execveat"):
            path = _text(process, arguments[call == "execveat"])
            return self._refuse(f"start the program {path}", errno.EACCES)
        if call in _LEAVES:
            return self._refuse("leave its group of processes")
        what = f" {arguments[_VALUES[call]]:#x}" if call in _VALUES else ""
        error = errno.EOPNOTSUPP if "xattr" in call else errno.EPERM  # as of other file systems
        if call.isdecimal() or call.startswith("io_uring"):  # as of older kernels
            error = errno.ENOSYS
        return self._refuse(f"call {call}{what}", error)

    def _is_own(self, process: int) -> bool:
        with suppress(OSError):
            return process >= 0 and os.getsid(process) == self._session
        return False

    def _start(self, flags: int) -> int:
        """Decide on a process or thread; only what runs now counts."""
        if flags & _NAMESPACES:
            return self._refuse("make a namespace")
        self._forked = self._forked or not flags & _THREAD
        self._at_most += 1
        if self._at_most > _MOST_AT_ONCE:  # what has ended since does not count
            processes = self._processes() if self._forked else [self._session]
            self._at_most = 1 + sum(int(_status(process, "Threads")) for process in processes)
        if self._at_most <= _MOST_AT_ONCE:
            return _GOES_ON
        return self._refuse(f"start more than {_MOST_AT_ONCE} processes and threads", errno.EAGAIN)

    def _look(self) -> None:
        """End the child when all its processes or files together take more than they may."""
        if not self._session or time.monotonic() < self._looked + _LOOK:
            return
        began = time.monotonic()
        processes = self._processes() if self._forked else [self._session]
        files = sum(map(_size, self._rooms)) + sum(map(_unnamed, processes))
        memory = 0
        if self._forked:
            memory = sum(map(_own_memory, processes)) - self._at_start
        now = time.monotonic()
        self._looked = now + 10 * (now - began)  # of many processes, too, a tenth of the time
        if max(files, memory) > self._most:
            self.exhausted = self.exhausted or memory > self._most
            kind = "memory" if memory > self._most else "files"
            self._refuse(f"take more than {self._most / 1e6:g} MB of {kind}")
            with suppress(OSError):
                os.killpg(self._session, signal.SIGKILL)

    def _processes(self) -> list[int]:
        every = (int(name) for name in os.listdir("/proc") if name.isdecimal())  # noqa: PTH208
        return [process for process in every if self._is_own(process)]

    def _path(self, process: int, folder: int | None, place: int | None, given: list[int]) -> str:
        """Return the path that the arguments mean."""
        path = _text(process, given[place]) if place is not None and given[place] else ""
        if path.startswith("/"):
            return path
        at = _HERE if folder is None else ctypes.c_int(given[folder]).value
        base = os.readlink(f"/proc/{process}/cwd" if at == _HERE else f"/proc/{process}/fd/{at}")  # noqa: PTH115
        return os.path.join(base, path) if path else base  # noqa: PTH118 (many calls)

    def _at_path(self, process: int, call: str, arguments: list[int]) -> int:
        """Name what Landlock will deny, which decides: the path can change after it was read."""
        for folder, place, verb in _PATHS[call]:
            path = self._path(process, folder, place, arguments)
            flags = 0
            if not verb:
                flags = arguments[place + 1]
                if call == "openat2":
                    flags = int.from_bytes(_memory(process, flags, 8), "little")
                writes = flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC)
                verb = "write" if writes else "read"
            if self._is_outside(process, path, verb):
                error = self._refuse(f"{verb} {path}", errno.EACCES)
                return error if flags & os.O_PATH else _GOES_ON
        return _GOES_ON

    def _is_outside(self, process: int, path: str, verb: str) -> bool:
        real = os.path.realpath(path)
        us = f"/proc/{os.getpid()}/"
        if path.startswith(f"/proc/{process}/") or (real.startswith(us) and us not in path):
            return False  # of the process itself, such as /proc/self
        if sandbox.is_below(real, self._readable if verb == "read" else self._writable):
            return False
        return verb != "read" or os.path.lexists(path)

    def _refuse(self, what: str, error: int = errno.EPERM) -> int:
        what = "".join(c if c.isprintable() else "?" for c in what[:_LONGEST])
        entry = (self._where(), what)
        if entry not in self.tried and len(self.tried) < _MOST_NOTED:
            self.tried.append(entry)
        return error


@cache
def _code(allow: frozenset[str]) -> bytes:
    return program(sandbox.numbers(), sandbox.processor(), allow)


def _status(process: int, name: str) -> str:
    """Return a line of /proc/PID/status, "0" of a process that is gone."""
    with suppress(OSError):
        lines = Path(f"/proc/{process}/status").read_text(errors="replace")
        return lines.partition(f"\n{name}:")[2].partition("\n")[0].split()[0]
    return "0"


def _own_memory(process: int) -> int:
    """Return the memory (bytes) of a process that no file holds, its share of what is shared."""
    with suppress(OSError):
        text = Path(f"/proc/{process}/smaps_rollup").read_text()
        found = re.findall(r"^Pss_(?:Anon|Shmem): *(\d+)", text, re.MULTILINE)
        return 1024 * sum(map(int, found))
    return 0


def _size(folder: str) -> int:
    """Return the space (bytes) of the files in a folder."""
    size = 0
    for place, _, files in os.walk(folder):
        for name in files:
            with suppress(OSError):
                size += 512 * os.lstat(f"{place}/{name}").st_blocks
    return size


def _unnamed(process: int) -> int:
    """Return the space (bytes) of the files that a process has open after they were deleted."""
    size = 0
    with suppress(OSError):
        for entry in os.scandir(f"/proc/{process}/fd"):
            with suppress(OSError):
                found = entry.stat()
                size += 512 * found.st_blocks * (S_ISREG(found.st_mode) and not found.st_nlink)
    return size


def _memory(process: int, place: int, size: int) -> bytes:
    with Path(f"/proc/{process}/mem").open("rb", buffering=0) as memory:
        memory.seek(place)
        return memory.read(size)


def _text(process: int, place: int) -> str:
    """Return the text at an address, "?" where it cannot be read."""
    try:
        near = _memory(process, place, min(4096, 4096 - place % 4096))
        if b"\0" not in near:
            near += _memory(process, place + len(near), 4096)
    except (OSError, OverflowError):
        return "?"
    return near.partition(b"\0")[0].decode(errors="replace")
