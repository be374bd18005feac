"""A sandbox for untrusted native code, of Linux's Landlock and seccomp (x86-64 and arm64).

The child restricts itself by `enter` before it loads the code. Landlock denies files and signals;
a seccomp filter passes the calls that matter to the parent, whose `Guard` denies those that
Landlock cannot, and notes what was tried, so that a message can name it.
"""

from __future__ import annotations

import array
import ctypes
import errno
import os
import select
import socket
import struct
import sys
import threading
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path

NETWORK, EXEC = "network", "exec"
_SYSTEM = ("/usr", "/lib", "/lib32", "/lib64", "/bin", "/sbin", "/etc", "/opt", "/nix", "/gnu")
_KERNEL = ("/dev", "/sys", "/proc/sys", "/proc/cpuinfo", "/proc/meminfo", "/proc/stat")
_MOST_STARTED = 256  # processes
_MOST_NOTED = 20

# Landlock (linux/landlock.h): calls, rights
_CREATE_RULESET, _ADD_RULE, _RESTRICT_SELF = 444, 445, 446
_EXECUTE, _WRITE, _READ, _READ_FOLDER = 1, 2, 4, 8
_REFER, _TRUNCATE = 1 << 13, 1 << 14
_ALL = (1 << 13) - 1
_OF_FILES = _EXECUTE | _WRITE | _READ | _TRUNCATE
_ABSTRACT_SOCKETS, _SIGNALS = 1, 2

# seccomp (linux/seccomp.h) and prctl
_NO_NEW_PRIVILEGES, _SET_FILTER, _NEW_LISTENER, _CONTINUE = 38, 1, 8, 1
_SPECULATION = 4  # as without a filter: until Linux 5.15 stores were slower behind one
_ALLOW, _ERRNO, _NOTIFY, _KILL = 0x7FFF0000, 0x00050000, 0x7FC00000, 0x80000000
_RECEIVE, _SEND = 0xC0502100, 0xC0182101
_NOTE, _ANSWER = struct.Struct("<QIIiIQ6Q"), struct.Struct("<QqiI")

_ABSENT = -1
_PROCESSORS = {  # machine -> its number for seccomp, the call seccomp itself, and its column below
    "x86_64": (0xC000003E, 317, 0),
    "aarch64": (0xC00000B7, 277, 1),
}
_CALLS = {  # -> numbers
    "socket": (41, 198),
    "ptrace": (101, 117),
    "process_vm_readv": (310, 270),
    "process_vm_writev": (311, 271),
    "setsid": (112, 157),
    "setpgid": (109, 154),
    "execve": (59, 221),
    "execveat": (322, 281),
    "kill": (62, 129),
    "tkill": (200, 130),
    "tgkill": (234, 131),
    "clone": (56, 220),
    "fork": (57, _ABSENT),
    "vfork": (58, _ABSENT),
    "chmod": (90, _ABSENT),
    "chown": (92, _ABSENT),
    "lchown": (94, _ABSENT),
    "fchmodat": (268, 53),
    "fchownat": (260, 54),
    "fchmodat2": (452, 452),
    "open": (2, _ABSENT),
    "creat": (85, _ABSENT),
    "openat": (257, 56),
    "openat2": (437, 437),
    "unlink": (87, _ABSENT),
    "unlinkat": (263, 35),
    "rmdir": (84, _ABSENT),
    "truncate": (76, 45),
    "mkdir": (83, _ABSENT),
    "mkdirat": (258, 34),
    "rename": (82, _ABSENT),
    "renameat": (264, 38),
    "renameat2": (316, 276),
    "symlink": (88, _ABSENT),
    "symlinkat": (266, 36),
    "link": (86, _ABSENT),
    "linkat": (265, 37),
}
_UNKNOWN = {"clone3": (435, 435), "io_uring_setup": (425, 425)}  # as in an older kernel
_DENIED = {
    **dict.fromkeys(("ptrace", "process_vm_readv", "process_vm_writev"), "trace a process"),
    **dict.fromkeys(("setsid", "setpgid"), "leave its group of processes"),
}
_CHANGES = {"chmod", "chown", "lchown", "fchmodat", "fchownat", "fchmodat2"}
_PATHS = {  # call -> places of the folder, if any, and the path among its arguments, and the verb
    **dict.fromkeys(("creat", "truncate", "mkdir", "chmod", "chown", "lchown"), (None, 0, "write")),
    **dict.fromkeys(("unlink", "rmdir", "rename"), (None, 0, "delete")),
    **dict.fromkeys(("unlinkat", "renameat", "renameat2"), (0, 1, "delete")),
    **dict.fromkeys(("mkdirat", "fchmodat", "fchownat", "fchmodat2"), (0, 1, "write")),
    "symlink": (None, 1, "write"),
    "symlinkat": (1, 2, "write"),
    "link": (None, 1, "write"),
    "linkat": (2, 3, "write"),
    "open": (None, 0, ""),
    "openat": (0, 1, ""),
    "openat2": (0, 1, ""),
}
_THREAD = 0x10000  # CLONE_THREAD


def unavailable() -> str:
    """Return why this system has no sandbox, "" where it has one."""
    if sys.platform != "linux" or os.uname().machine not in _PROCESSORS:
        return "there is no sandbox on this system"
    if _landlock() < 1:
        return f"Linux {os.uname().release} has no Landlock; the sandbox needs Linux 5.13 or newer"
    return ""


def _landlock() -> int:
    """Return the version of Landlock, below 1 where there is none."""
    return int(ctypes.CDLL(None).syscall(_CREATE_RULESET, None, ctypes.c_size_t(0), 1))


def interpreter_folders(packages: Iterable[Path]) -> list[str]:
    """Return what Python and some packages read when they import more of themselves."""
    paths = {sys.prefix, sys.base_prefix, str(Path(os.__file__).parent)}
    paths |= {path for path in sys.path if path.endswith(("-packages", ".zip"))}
    return sorted({*paths, *map(str, packages)})


def permissions(allow: Iterable[str]) -> tuple[list[str], frozenset[str]]:
    """Return the folders and the other words of ``--allow``.

    Raises
    ------
    ValueError
        When a word is not ``network``, ``exec`` or ``files=DIR`` with a folder.
    """
    folders, words = [], set()
    for word in allow:
        if word.startswith("files="):
            folder = Path(word.removeprefix("files=")).absolute()
            if word == "files=" or not folder.is_dir():
                raise ValueError(f"allow is {word!r}, expected a folder that exists as DIR")
            folders.append(str(folder))
        elif word in (NETWORK, EXEC):
            words.add(word)
        else:
            raise ValueError(f"allow is {word!r}, expected 'network', 'exec' or 'files=DIR'")
    return folders, frozenset(words)


def enter(
    readable: Iterable[str], writable: Iterable[str], allow: frozenset[str], file: int
) -> None:
    """Restrict this thread and all that it starts, for good.

    Parameters
    ----------
    readable, writable : paths, with all below them, besides those of the system
    allow : NETWORK, EXEC
    file : descriptor of the socket whose other end a Guard has

    Raises
    ------
    OSError
        When the kernel refuses.
    """
    readable, writable = list(readable), list(writable)
    within = [*_SYSTEM, *readable]  # imports look into no other folder
    sys.path[:] = [path for path in sys.path if _is_below(path, within)]
    call = ctypes.CDLL(None, use_errno=True).syscall
    version = _landlock()
    everything = _ALL | (_REFER if version > 1 else 0) | (_TRUNCATE if version > 2 else 0)
    scopes = _SIGNALS | (0 if NETWORK in allow else _ABSTRACT_SOCKETS)
    rules = struct.pack("<QQQ", everything, 0, scopes if version > 5 else 0)
    size = 24 if version > 5 else 8
    _prctl = ctypes.CDLL(None, use_errno=True).prctl
    _checked(_prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0))
    ruleset = _checked(call(_CREATE_RULESET, rules, ctypes.c_size_t(size), 0))
    read = _EXECUTE | _READ | _READ_FOLDER
    for paths, rights in (
        ((*_SYSTEM, *_KERNEL, "/proc/self", *readable), read),
        (("/dev/null", "/dev/zero", "/dev/tty"), read | _WRITE),
        (writable, everything),
    ):
        for path in paths:
            with suppress(FileNotFoundError, NotADirectoryError):
                place = os.open(path, os.O_PATH | os.O_CLOEXEC)
                mine = rights if Path(path).is_dir() else rights & _OF_FILES & everything
                rule = struct.pack("<Qi", mine, place)
                _checked(call(_ADD_RULE, ruleset, 1, rule, 0))
                os.close(place)
    _checked(call(_RESTRICT_SELF, ruleset, 0))
    os.close(ruleset)
    processor, seccomp, column = _PROCESSORS[os.uname().machine]
    code = _filter(processor, column, allow)
    text = ctypes.create_string_buffer(code)
    program = struct.pack("<HxxxxxxQ", len(code) // 8, ctypes.addressof(text))
    listener = _checked(call(seccomp, _SET_FILTER, _NEW_LISTENER | _SPECULATION, program))
    with socket.socket(fileno=file) as channel:
        given = (socket.SOL_SOCKET, socket.SCM_RIGHTS, array.array("i", [listener]))
        channel.sendmsg([b"x"], [given])
    os.close(listener)


def _checked(result: int) -> int:
    if result < 0:
        raise OSError(ctypes.get_errno(), f"sandbox: {os.strerror(ctypes.get_errno())}")
    return result


def _filter(processor: int, column: int, allow: frozenset[str]) -> bytes:
    """Return the program (struct sock_filter) that sorts the calls."""
    load, equal, common, end = 0x20, 0x15, 0x45, 0x06
    skipped = {"execve", "execveat"} if EXEC in allow else set[str]()
    skipped |= {"socket"} if NETWORK in allow else set()
    noted = [n[column] for name, n in _CALLS.items() if name not in skipped]
    noted.remove(_CALLS["clone"][column])
    lines = [(load, 0, 0, 4), (equal, 1, 0, processor), (end, 0, 0, _KILL), (load, 0, 0, 0)]
    for numbers in _UNKNOWN.values():
        lines += [(equal, 0, 1, numbers[column]), (end, 0, 0, _ERRNO | errno.ENOSYS)]
    for number in set(noted) - {_ABSENT}:
        lines += [(equal, 0, 1, number), (end, 0, 0, _NOTIFY)]
    lines += [(equal, 0, 3, _CALLS["clone"][column]), (load, 0, 0, 16)]  # flags
    lines += [(common, 1, 0, _THREAD), (end, 0, 0, _NOTIFY), (end, 0, 0, _ALLOW)]
    return b"".join(struct.pack("<HBBI", *line) for line in lines)


class Guard:
    """The parent's part: denies and notes what a child in the sandbox tries.

    Parameters
    ----------
    readable, writable : as for `enter`
    where : returns what the child is doing, for the notes

    Attributes
    ----------
    file : the descriptor that the child inherits, to be closed after it has started
    tried : what was denied: ``(where, what)``, such as ``("a: fmi2DoStep", "read /root/x")``
    """

    def __init__(
        self,
        readable: Iterable[str],
        writable: Iterable[str],
        where: Callable[[], str] = str,
    ) -> None:
        import fcntl  # not on Windows

        self._readable = [*_SYSTEM, *_KERNEL, *map(os.path.realpath, readable)]
        self._writable = [*map(os.path.realpath, writable), "/dev"]
        self._where = where
        self.tried: list[tuple[str, str]] = []
        self._started, self._child = 0, 0
        ours, theirs = socket.socketpair()
        with theirs:  # the child needs no number of a standard stream
            self.file = fcntl.fcntl(theirs.fileno(), fcntl.F_DUPFD_CLOEXEC, 3)
        self._names: dict[int, str] = {}
        self._thread = threading.Thread(target=self._serve, args=(ours,), daemon=True)
        self._thread.start()

    def close_file(self) -> None:
        """Close what the child has inherited."""
        if self.file >= 0:
            os.close(self.file)
            self.file = -1

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
        column = _PROCESSORS[os.uname().machine][2]
        self._names = {n[column]: name for name, n in _CALLS.items()}
        ioctl = ctypes.CDLL(None, use_errno=True).ioctl
        poll = select.poll()
        poll.register(files[0], select.POLLIN)
        note = ctypes.create_string_buffer(_NOTE.size)
        try:
            while all(events & select.POLLIN for _, events in poll.poll()):
                ctypes.memset(note, 0, _NOTE.size)
                if ioctl(files[0], ctypes.c_ulong(_RECEIVE), note) < 0:
                    continue  # the caller was killed meanwhile
                number, process, _, call, _, _, *arguments = _NOTE.unpack(note.raw)
                denied = 0
                with suppress(OSError, ValueError):
                    denied = self._denied(process, self._names.get(call, ""), arguments)
                answer = _ANSWER.pack(number, 0, -denied, 0 if denied else _CONTINUE)
                ioctl(files[0], ctypes.c_ulong(_SEND), answer)
        finally:
            os.close(files[0])

    def _denied(self, process: int, call: str, arguments: list[int]) -> int:
        """Return the error that a call gets, 0 where it goes on to the kernel."""
        self._child = self._child or process
        if call in _PATHS:
            return self._at_path(process, call, arguments)
        if call in ("fork", "vfork", "clone"):
            self._started += 1
            if self._started <= _MOST_STARTED:
                return 0
            return self._refuse(f"start more than {_MOST_STARTED} processes", errno.EAGAIN)
        if call in ("kill", "tkill", "tgkill"):
            target = ctypes.c_int(arguments[0]).value
            group = os.getsid(process)
            if target == 0 or (target > 0 and _session(target) == group) or -target == group:
                return 0
            return self._refuse(f"send a signal to process {target}")
        if call == "socket":
            return self._refuse("open a network connection", errno.EACCES)
        if call in ("execve", "execveat"):
            at = arguments[0 if call == "execve" else 1]
            return self._refuse(f"start the program {_text(process, at)}", errno.EACCES)
        return self._refuse(_DENIED.get(call, call))

    def _at_path(self, process: int, call: str, arguments: list[int]) -> int:
        folder, place, verb = _PATHS[call]
        path = _text(process, arguments[place])
        if not path.startswith("/"):
            at = -100 if folder is None else ctypes.c_int(arguments[folder]).value
            base = f"/proc/{process}/cwd" if at == -100 else f"/proc/{process}/fd/{at}"
            path = os.path.join(os.readlink(base), path)  # noqa: PTH115, PTH118 (many calls)
        if not verb:
            flags = arguments[place + 1]
            if call == "openat2":
                flags = int.from_bytes(_memory(process, flags, 8), "little")
            writes = flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC)
            verb = "write" if writes else "read"
        real = os.path.realpath(path)
        us = f"/proc/{os.getpid()}/"
        if path.startswith(f"/proc/{process}/") or (real.startswith(us) and us not in path):
            return 0  # of the process itself, such as /proc/self
        allowed = self._writable if verb != "read" else [*self._readable, *self._writable]
        if _is_below(real, allowed):
            return 0
        if verb == "read" and not os.path.lexists(path):
            return 0
        self._refuse(f"{verb} {path}")
        return errno.EACCES if call in _CHANGES else 0  # the others Landlock denies

    def _refuse(self, what: str, error: int = errno.EPERM) -> int:
        entry = (self._where(), what)
        if entry not in self.tried and len(self.tried) < _MOST_NOTED:
            self.tried.append(entry)
        return error


def _is_below(path: str, folders: Iterable[str]) -> bool:
    return any(path == one or path.startswith(f"{one.rstrip('/')}/") for one in folders)


def _session(process: int) -> int:
    try:
        return os.getsid(process)
    except OSError:
        return -1


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
