"""The system calls that code in the sandbox may make, and the seccomp filter made from them.

A call that is not listed, or whose arguments differ from what is listed, goes to the parent, which
refuses and names it (`Guard`). `ALLOWED` is also the table of docs/isolation.md.
"""

import errno
import struct
from collections.abc import Mapping
from typing import NamedTuple

from stickslip.fmi.process.sandbox import EXEC, NETWORK, OWN

SHARED, ANONYMOUS, HUGE = 0x1, 0x20, 0x40000  # mmap
_STREAM = 1  # socketpair
ALLOW, ERROR, NOTIFY = 0x7FFF0000, 0x00050000, 0x7FC00000
_LOAD, _AND, _EQUAL, _AT_LEAST, _END = 0x20, 0x54, 0x15, 0x35, 0x06
_INSTRUCTION = struct.Struct("<HBBI")
_NUMBER, _ARCHITECTURE, _ARGUMENTS = 0, 4, 16  # bytes in struct seccomp_data


class Argument(NamedTuple):
    """What an argument must be: in the bits of ``mask``, one of the values."""

    place: int
    values: tuple[int, ...]
    mask: int = 0xFFFFFFFF
    upper: bool = False  # the upper 32 bits


class Allowed(NamedTuple):
    """Calls allowed for one reason; those that ``where`` does not let through ask the parent."""

    why: str  # the reason
    calls: str  # their names
    limit: str = ""  # which of them, in words
    where: tuple[Argument, ...] = ()  # what the arguments must be
    asks: bool = False  # whether the parent decides on each
    word: str = ""  # of ``--allow`` that they need


_PROCESSES = "processes and threads of its own"
_CLOCK = "clock, random numbers, and what it is"
_TERMINAL = (0x5401, 0x5413, 0x541B, 0x5421, 0x5450, 0x5451)  # of ioctl
_INTERFACES = (0x8910, 0x8912, 0x8913, 0x8915, 0x8919, 0x891B, 0x8921, 0x8927, 0x8933)
_NO_ADDRESS = (Argument(4, (0,)), Argument(4, (0,), upper=True))
ALLOWED = (
    Allowed(
        "own memory",
        "brk munmap mprotect mremap madvise mincore msync mseal map_shadow_stack membarrier"
        " get_mempolicy set_mempolicy mbind pkey_alloc pkey_free pkey_mprotect",
    ),
    Allowed(
        "own memory",
        "mmap",
        "no huge pages; memory shared with own processes up to `--memory`",
        (Argument(3, (0, ANONYMOUS, SHARED), SHARED | ANONYMOUS | HUGE),),
    ),
    Allowed(
        "files by handle",
        "read write readv writev pread64 pwrite64 preadv pwritev preadv2 pwritev2 lseek close"
        " close_range fstat fstatfs dup dup2 dup3 getdents getdents64 ftruncate fallocate fsync"
        " fdatasync fadvise64 readahead sendfile copy_file_range fchdir",
    ),
    Allowed(
        "files by handle",
        "fcntl",
        "duplicates, flags, and locks of own files (without effect)",
        (Argument(1, (0, 1, 2, 3, 4, 5, 36, 1030, 1032, 1034)),),
    ),
    Allowed(
        "files by handle",
        "ioctl",
        "whether it is a terminal and how large, bytes to read, close on exec, not blocking",
        (Argument(1, _TERMINAL),),
    ),
    Allowed(
        "waiting",
        "pipe pipe2 poll ppoll select pselect6 epoll_create epoll_create1 epoll_ctl epoll_wait"
        " epoll_pwait epoll_pwait2 eventfd eventfd2 timerfd_create timerfd_settime timerfd_gettime"
        " signalfd signalfd4 nanosleep clock_nanosleep pause restart_syscall",
    ),
    Allowed(
        "waiting",
        "socketpair",
        "connected pairs of streams",
        (Argument(0, (1,)), Argument(1, (_STREAM,), 0xF)),
    ),
    Allowed("waiting", "recvfrom recvmsg sendmsg shutdown getsockopt getsockname getpeername"),
    Allowed("waiting", "sendto", "without an address", _NO_ADDRESS),
    Allowed(
        "what exists, not what it holds",
        "stat lstat newfstatat statx access faccessat faccessat2 readlink readlinkat statfs getcwd"
        " chdir umask",
    ),
    Allowed(
        "files by name",
        "open openat openat2 creat unlink unlinkat rmdir mkdir mkdirat rename renameat renameat2"
        " link linkat",
        "those listed below (Landlock)",
        asks=True,
    ),
    Allowed(
        "mode, times and locks of files",
        "chmod fchmod fchmodat fchmodat2 utime utimes futimesat utimensat flock",
        "own files, without effect",
        asks=True,
    ),
    Allowed(_PROCESSES, "clone fork vfork", "256 at a time", asks=True),
    Allowed(
        _PROCESSES,
        "exit exit_group wait4 waitid futex futex_waitv futex_wait futex_wake futex_requeue"
        " set_tid_address set_robust_list rseq arch_prctl sched_yield getcpu",
    ),
    Allowed(
        _PROCESSES,
        "sched_setaffinity sched_setscheduler sched_setparam sched_setattr",
        "its own",
        (Argument(0, (0, OWN)),),
    ),
    Allowed(_PROCESSES, "setpriority", "its own", (Argument(0, (0,)), Argument(1, (0, OWN)))),
    Allowed(
        _PROCESSES,
        "kill tkill tgkill rt_sigqueueinfo rt_tgsigqueueinfo",
        "to itself and what it has started",
        (Argument(0, (0, OWN)),),
    ),
    Allowed(_PROCESSES, "setrlimit"),
    Allowed(_PROCESSES, "prlimit64", "its own", (Argument(0, (0, OWN)),)),
    Allowed(
        _PROCESSES,
        "prctl",
        "names of threads and of memory, the timer's slack, and what only reads",
        (Argument(0, (1, 2, 3, 7, 15, 16, 21, 23, 25, 27, 29, 30, 38, 39, 42, 0x53564D41)),),
    ),
    Allowed(
        "own signals and timers",
        "rt_sigaction rt_sigprocmask rt_sigreturn rt_sigsuspend rt_sigpending rt_sigtimedwait"
        " sigaltstack alarm getitimer setitimer timer_create timer_settime timer_gettime"
        " timer_getoverrun timer_delete",
    ),
    Allowed(
        _CLOCK,
        "clock_gettime clock_getres gettimeofday time times getrandom getpid gettid getppid getuid"
        " geteuid getgid getegid getresuid getresgid getgroups getpgrp getpgid getsid capget"
        " getrusage getrlimit sysinfo uname getpriority sched_getaffinity sched_getscheduler"
        " sched_getparam sched_getattr sched_get_priority_max sched_get_priority_min"
        " sched_rr_get_interval",
    ),
    Allowed(_CLOCK, "personality", "reads it", (Argument(0, (0xFFFFFFFF,)),)),
    Allowed("programs, in the same sandbox", "execve execveat", word=EXEC),
    Allowed(
        "the network",
        "connect bind listen accept accept4 sendto sendmmsg recvmmsg setsockopt",
        word=NETWORK,
    ),
    Allowed("the network", "socket", "IPv4, IPv6, routes", asks=True, word=NETWORK),
    Allowed(
        "the network",
        "ioctl",
        "also: names and addresses of interfaces",
        (Argument(1, (*_TERMINAL, *_INTERFACES)),),
        word=NETWORK,
    ),
)
_UNKNOWN = ("clone3",)
"""As in an older kernel, whose callers fall back: its arguments cannot be looked into."""


def program(numbers: Mapping[str, int], processor: int, allow: frozenset[str]) -> bytes:
    """Return the filter (struct sock_filter) of a processor for some words of ``--allow``."""
    codes: dict[int, bytes] = {}
    for rule in ALLOWED:
        if not rule.word or rule.word in allow:
            code = _NOTED if rule.asks else _tested(rule.where)
            codes |= {numbers[name]: code for name in rule.calls.split() if name in numbers}
    codes |= {numbers[name]: _line(_END, ERROR | errno.ENOSYS) for name in _UNKNOWN}
    ranges = [(0, _NOTED)]
    for number in sorted({*codes, *(number + 1 for number in codes)}):
        code = codes.get(number, _NOTED)
        if ranges[-1][1] != code:
            ranges.append((number, code))
    checked = _line(_LOAD, _ARCHITECTURE) + _line(_EQUAL, processor, 1) + _NOTED
    return checked + _line(_LOAD, _NUMBER) + _search(ranges)


def _line(what: int, value: int, then: int = 0) -> bytes:
    """Return an instruction; a comparison that holds skips so many."""
    return _INSTRUCTION.pack(what, then, 0, value)


_NOTED, _PASSED = _line(_END, NOTIFY), _line(_END, ALLOW)


def _tested(where: tuple[Argument, ...]) -> bytes:
    """Return the code that allows a call with such arguments, and passes on others."""
    lines = []
    for test in where:
        lines.append(_line(_LOAD, _ARGUMENTS + 8 * test.place + 4 * test.upper))
        if test.mask != 0xFFFFFFFF:
            lines.append(_line(_AND, test.mask))
        n = len(test.values)
        lines += [_line(_EQUAL, value, n - k) for k, value in enumerate(test.values)]
        lines.append(_NOTED)
    return b"".join((*lines, _PASSED))


def _search(ranges: list[tuple[int, bytes]]) -> bytes:
    """Return the code that finds the range of a call by halving."""
    if len(ranges) == 1:
        return ranges[0][1]
    half = len(ranges) // 2
    below = _search(ranges[:half])
    skip = _line(_AT_LEAST, ranges[half][0], len(below) // _INSTRUCTION.size)
    return skip + below + _search(ranges[half:])
