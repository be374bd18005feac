"""A sandbox for untrusted native code, of Linux's Landlock and seccomp (x86-64 and arm64).

The child restricts itself by `enter` before it loads the code. Landlock allows files and signals,
a seccomp filter the system calls of ``permitted.py``; the others go to the parent, whose `Guard`
refuses and names them.
"""

from __future__ import annotations

import array
import ctypes
import os
import socket
import struct
import sys
from collections.abc import Iterable, Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from stat import S_ISDIR
from typing import NamedTuple

from stickslip.fmi.process.calls import processor

NETWORK, EXEC = "network", "exec"
OWN = 0x0F4EC0DE
"""In the filter: the number of the process that enters the sandbox, which puts it in its place."""

SYSTEM = (
    *("/usr", "/lib", "/lib32", "/lib64", "/bin", "/sbin", "/opt", "/nix/store", "/gnu/store"),
    *("/dev/random", "/dev/urandom", "/sys/devices/system", "/sys/fs/cgroup", "/sys/kernel/mm"),
    *("/proc/sys", "/proc/cpuinfo", "/proc/meminfo", "/proc/stat", "/proc/cgroups"),
    *("/proc/filesystems", "/proc/version", "/proc/uptime", "/proc/loadavg"),
)
"""What can be read, with all below it."""
SETTINGS = (
    *("ld.so.cache", "ld.so.preload", "ld.so.conf", "ld.so.conf.d", "localtime", "timezone"),
    *("passwd", "group", "nsswitch.conf", "hosts", "host.conf", "resolv.conf", "gai.conf"),
    *("services", "protocols", "os-release", "machine-id", "locale.alias", "fonts", "mono"),
    *("ssl/certs", "ssl/openssl.cnf", "pki/tls/certs", "ca-certificates", "alternatives"),
    *("java-11-openjdk", "java-17-openjdk", "java-21-openjdk"),
)
"""What of /etc can be read: no passwords and keys, which root could."""
VARIABLES = (
    *("PATH", "HOME", "LANG", "LANGUAGE", "TZ"),
    *("TMPDIR", "XDG_CACHE_HOME", "LD_LIBRARY_PATH"),
)
FAMILIES = ("LC_", "PYTHON", "STICKSLIP_", "OMP_", "GOMP_", "KMP_", "MKL_", "OPENBLAS_")
"""What of the environment goes to the child: these variables, and those that begin so."""

# Landlock (linux/landlock.h): calls, rights
_CREATE_RULESET, _ADD_RULE, _RESTRICT_SELF = 444, 445, 446
_EXECUTE, _WRITE, _READ, _READ_FOLDER = 1, 2, 4, 8
_REFER, _TRUNCATE = 1 << 13, 1 << 14
_ALL = (1 << 13) - 1
_SPECIAL = 1 << 6 | 1 << 9 | 1 << 10 | 1 << 11 | 1 << 12  # devices, sockets, pipes, links
_OF_FILES = _EXECUTE | _WRITE | _READ | _TRUNCATE
_CONNECTIONS = 3  # TCP
_ABSTRACT_SOCKETS, _SIGNALS = 1, 2

# seccomp (linux/seccomp.h), prctl, capset
_NO_NEW_PRIVILEGES, _SET_FILTER, _NEW_LISTENER = 38, 1, 8
_SPECULATION = 4  # as without a filter: until Linux 5.15 stores were slower behind one
_CAPABILITIES = 0x20080522


def unavailable() -> str:
    """Return why this system has no sandbox, "" where it has one."""
    if sys.platform != "linux" or not processor():
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


class Permissions(NamedTuple):
    """What is allowed besides.

    Attributes
    ----------
    folders : that may be read and written
    words : NETWORK, EXEC
    variables : of the environment
    """

    folders: tuple[str, ...] = ()
    words: frozenset[str] = frozenset()
    variables: frozenset[str] = frozenset()

    @classmethod
    def of(cls, allow: Iterable[str]) -> Permissions:
        """Return what the words of ``--allow`` mean.

        Raises
        ------
        ValueError
            When a word is not ``network``, ``exec``, ``env=NAME`` or ``files=DIR`` with a folder.
        """
        folders, words, variables = [], set(), set()
        for word in allow:
            kind, _, what = word.partition("=")
            if kind == "files" and what != word:
                folder = Path(what).absolute()
                if not what or not folder.is_dir():
                    raise ValueError(f"allow is {word!r}, expected a folder that exists as DIR")
                folders.append(str(folder))
            elif kind == "env" and what:
                variables.add(what)
            elif word in (NETWORK, EXEC):
                words.add(word)
            else:
                raise ValueError(
                    f"allow is {word!r}, expected 'network', 'exec' or 'files=DIR', or 'env=NAME'"
                )
        return cls(tuple(folders), frozenset(words), frozenset(variables))

    def environment(self) -> dict[str, str]:
        """Return what of this process's environment the child gets."""
        known = {*VARIABLES, *self.variables}
        return {n: v for n, v in os.environ.items() if n in known or n.startswith(FAMILIES)}


def enter(
    readable: Sequence[str],
    writable: Sequence[str],
    allow: frozenset[str],
    file: int,
    code: bytes,
    seccomp: int,
) -> None:
    """Restrict this process and all that it starts, for good.

    Parameters
    ----------
    readable, writable : paths, with all below them
    allow : NETWORK, EXEC
    file : descriptor of the socket whose other end a Guard has
    code : the filter of system calls, without the number of this process
    seccomp : number of the call that installs it

    Raises
    ------
    OSError
        When the kernel refuses, or there are other threads, which would stay outside.
    """
    if len(os.listdir("/proc/self/task")) > 1:  # noqa: PTH208 (one of many system calls)
        raise OSError("sandbox: other threads run already")
    sys.path[:] = [path for path in sys.path if is_below(path, readable)]  # imports look there
    library = ctypes.CDLL(None, use_errno=True)
    nothing = ctypes.create_string_buffer(24)  # root keeps its files, not its powers
    _checked(library.capset(struct.pack("<Ii", _CAPABILITIES, 0), nothing))
    _checked(library.prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0))
    _restrict_files(library.syscall, readable, writable, allow)
    code = code.replace(struct.pack("<I", OWN), struct.pack("<I", os.getpid()))
    text = ctypes.create_string_buffer(code)
    given = struct.pack("<HxxxxxxQ", len(code) // 8, ctypes.addressof(text))
    flags = _NEW_LISTENER | _SPECULATION
    listener = _checked(library.syscall(seccomp, _SET_FILTER, flags, given))
    with socket.socket(fileno=file) as channel:
        handed = (socket.SOL_SOCKET, socket.SCM_RIGHTS, array.array("i", [listener]))
        channel.sendmsg([b"x"], [handed])
    os.close(listener)


def _restrict_files(
    call: ctypes._NamedFuncPointer,
    readable: Iterable[str],
    writable: Iterable[str],
    allow: frozenset[str],
) -> None:
    version = _landlock()
    everything = _ALL | (_REFER if version > 1 else 0) | (_TRUNCATE if version > 2 else 0)
    closed = NETWORK not in allow
    rules = struct.pack(
        "<QQQ", everything, _CONNECTIONS * closed, _SIGNALS | _ABSTRACT_SOCKETS * closed
    )
    size = 24 if version > 5 else 16 if version > 3 else 8
    ruleset = _checked(call(_CREATE_RULESET, rules, ctypes.c_size_t(size), 0))
    for paths, rights in (
        (("/proc/self", *readable), _EXECUTE | _READ | _READ_FOLDER),
        (("/dev/null",), _READ | _WRITE | _TRUNCATE),
        (writable, everything & ~_SPECIAL),
    ):
        for path in paths:
            with suppress(FileNotFoundError, NotADirectoryError, PermissionError):
                place = os.open(path, os.O_PATH | os.O_CLOEXEC)
                mine = -1 if S_ISDIR(os.fstat(place).st_mode) else _OF_FILES
                rule = struct.pack("<Qi", rights & everything & mine, place)
                _checked(call(_ADD_RULE, ruleset, 1, rule, 0))
                os.close(place)
    _checked(call(_RESTRICT_SELF, ruleset, 0))
    os.close(ruleset)


@cache
def system_paths() -> tuple[str, ...]:
    """Return what there is of SYSTEM and SETTINGS, none of it twice, without links."""
    found: list[str] = []
    for path in (*SYSTEM, *(f"/etc/{name}" for name in SETTINGS)):
        if os.path.lexists(path):
            real = os.path.realpath(path) if os.path.islink(path) else path  # noqa: PTH114 (faster)
            if not is_below(real, found):
                found.append(real)
    return tuple(found)


def is_below(path: str, folders: Iterable[str]) -> bool:
    """Return whether a path is one of some folders, or in one."""
    return any(path == one or path.startswith(f"{one.rstrip('/')}/") for one in folders)


def _checked(result: int) -> int:
    if result < 0:
        raise OSError(ctypes.get_errno(), f"sandbox: {os.strerror(ctypes.get_errno())}")
    return result
