"""A sandbox for untrusted native code, of Linux's Landlock and seccomp (x86-64 and arm64).

The child restricts itself by `enter` before it loads the code. Landlock allows files and signals,
a seccomp filter the system calls of ``permitted.py``; the others go to the parent, whose `Guard`
refuses and names them.
"""

import array
import ctypes
import os
import socket
import struct
import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from stat import S_ISDIR
from typing import NamedTuple, Self

_X86_64 = """
read write open close stat fstat lstat poll lseek mmap mprotect munmap brk rt_sigaction
rt_sigprocmask rt_sigreturn ioctl pread64 pwrite64 readv writev access pipe select sched_yield
mremap msync mincore madvise shmget shmat shmctl dup dup2 pause nanosleep getitimer alarm
setitimer getpid sendfile socket connect accept sendto recvfrom sendmsg recvmsg shutdown bind
listen getsockname getpeername socketpair setsockopt getsockopt clone fork vfork execve exit wait4
kill uname semget semop semctl shmdt msgget msgsnd msgrcv msgctl fcntl flock fsync fdatasync
truncate ftruncate getdents getcwd chdir fchdir rename mkdir rmdir creat link unlink symlink
readlink chmod fchmod chown fchown lchown umask gettimeofday getrlimit getrusage sysinfo times
ptrace getuid syslog getgid setuid setgid geteuid getegid setpgid getppid getpgrp setsid setreuid
setregid getgroups setgroups setresuid getresuid setresgid getresgid getpgid setfsuid setfsgid
getsid capget capset rt_sigpending rt_sigtimedwait rt_sigqueueinfo rt_sigsuspend sigaltstack utime
mknod uselib personality ustat statfs fstatfs sysfs getpriority setpriority sched_setparam
sched_getparam sched_setscheduler sched_getscheduler sched_get_priority_max sched_get_priority_min
sched_rr_get_interval mlock munlock mlockall munlockall vhangup modify_ldt pivot_root _sysctl
prctl arch_prctl adjtimex setrlimit chroot sync acct settimeofday mount umount2 swapon swapoff
reboot sethostname setdomainname iopl ioperm create_module init_module delete_module
get_kernel_syms query_module quotactl nfsservctl getpmsg putpmsg afs_syscall tuxcall security
gettid readahead setxattr lsetxattr fsetxattr getxattr lgetxattr fgetxattr listxattr llistxattr
flistxattr removexattr lremovexattr fremovexattr tkill time futex sched_setaffinity
sched_getaffinity set_thread_area io_setup io_destroy io_getevents io_submit io_cancel
get_thread_area lookup_dcookie epoll_create epoll_ctl_old epoll_wait_old remap_file_pages
getdents64 set_tid_address restart_syscall semtimedop fadvise64 timer_create timer_settime
timer_gettime timer_getoverrun timer_delete clock_settime clock_gettime clock_getres
clock_nanosleep exit_group epoll_wait epoll_ctl tgkill utimes vserver mbind set_mempolicy
get_mempolicy mq_open mq_unlink mq_timedsend mq_timedreceive mq_notify mq_getsetattr kexec_load
waitid add_key request_key keyctl ioprio_set ioprio_get inotify_init inotify_add_watch
inotify_rm_watch migrate_pages openat mkdirat mknodat fchownat futimesat newfstatat unlinkat
renameat linkat symlinkat readlinkat fchmodat faccessat pselect6 ppoll unshare set_robust_list
get_robust_list splice tee sync_file_range vmsplice move_pages utimensat epoll_pwait signalfd
timerfd_create eventfd fallocate timerfd_settime timerfd_gettime accept4 signalfd4 eventfd2
epoll_create1 dup3 pipe2 inotify_init1 preadv pwritev rt_tgsigqueueinfo perf_event_open recvmmsg
fanotify_init fanotify_mark prlimit64 name_to_handle_at open_by_handle_at clock_adjtime syncfs
sendmmsg setns getcpu process_vm_readv process_vm_writev kcmp finit_module sched_setattr
sched_getattr renameat2 seccomp getrandom memfd_create kexec_file_load bpf execveat userfaultfd
membarrier mlock2 copy_file_range preadv2 pwritev2 pkey_mprotect pkey_alloc pkey_free statx
io_pgetevents rseq uretprobe uprobe
"""
_ARM64 = """
io_setup io_destroy io_submit io_cancel io_getevents setxattr lsetxattr fsetxattr getxattr
lgetxattr fgetxattr listxattr llistxattr flistxattr removexattr lremovexattr fremovexattr getcwd
lookup_dcookie eventfd2 epoll_create1 epoll_ctl epoll_pwait dup dup3 fcntl inotify_init1
inotify_add_watch inotify_rm_watch ioctl ioprio_set ioprio_get flock mknodat mkdirat unlinkat
symlinkat linkat renameat umount2 mount pivot_root nfsservctl statfs fstatfs truncate ftruncate
fallocate faccessat chdir fchdir chroot fchmod fchmodat fchownat fchown openat close vhangup pipe2
quotactl getdents64 lseek read write readv writev pread64 pwrite64 preadv pwritev sendfile
pselect6 ppoll signalfd4 vmsplice splice tee readlinkat newfstatat fstat sync fsync fdatasync
sync_file_range2 timerfd_create timerfd_settime timerfd_gettime utimensat acct capget capset
personality exit exit_group waitid set_tid_address unshare futex set_robust_list get_robust_list
nanosleep getitimer setitimer kexec_load init_module delete_module timer_create timer_gettime
timer_getoverrun timer_settime timer_delete clock_settime clock_gettime clock_getres
clock_nanosleep syslog ptrace sched_setparam sched_setscheduler sched_getscheduler sched_getparam
sched_setaffinity sched_getaffinity sched_yield sched_get_priority_max sched_get_priority_min
sched_rr_get_interval restart_syscall kill tkill tgkill sigaltstack rt_sigsuspend rt_sigaction
rt_sigprocmask rt_sigpending rt_sigtimedwait rt_sigqueueinfo rt_sigreturn setpriority getpriority
reboot setregid setgid setreuid setuid setresuid getresuid setresgid getresgid setfsuid setfsgid
times setpgid getpgid getsid setsid getgroups setgroups uname sethostname setdomainname getrlimit
setrlimit getrusage umask prctl getcpu gettimeofday settimeofday adjtimex getpid getppid getuid
geteuid getgid getegid gettid sysinfo mq_open mq_unlink mq_timedsend mq_timedreceive mq_notify
mq_getsetattr msgget msgctl msgrcv msgsnd semget semctl semtimedop semop shmget shmctl shmat shmdt
socket socketpair bind listen accept connect getsockname getpeername sendto recvfrom setsockopt
getsockopt shutdown sendmsg recvmsg readahead brk munmap mremap add_key request_key keyctl clone
execve mmap fadvise64 swapon swapoff mprotect msync mlock munlock mlockall munlockall mincore
madvise remap_file_pages mbind get_mempolicy set_mempolicy migrate_pages move_pages
rt_tgsigqueueinfo perf_event_open accept4 recvmmsg - - - - - - - - - - - - - - - - wait4 prlimit64
fanotify_init fanotify_mark name_to_handle_at open_by_handle_at clock_adjtime syncfs setns
sendmmsg process_vm_readv process_vm_writev kcmp finit_module sched_setattr sched_getattr
renameat2 seccomp getrandom memfd_create bpf execveat userfaultfd membarrier mlock2
copy_file_range preadv2 pwritev2 pkey_mprotect pkey_alloc pkey_free statx io_pgetevents rseq
kexec_file_load
"""
_COMMON = """
pidfd_send_signal io_uring_setup io_uring_enter io_uring_register open_tree move_mount fsopen
fsconfig fsmount fspick pidfd_open clone3 close_range openat2 pidfd_getfd faccessat2
process_madvise epoll_pwait2 mount_setattr quotactl_fd landlock_create_ruleset landlock_add_rule
landlock_restrict_self memfd_secret process_mrelease futex_waitv set_mempolicy_home_node cachestat
fchmodat2 map_shadow_stack futex_wake futex_wait futex_requeue statmount listmount
lsm_get_self_attr lsm_set_self_attr lsm_list_modules mseal setxattrat getxattrat listxattrat
removexattrat open_tree_attr file_getattr file_setattr listns rseq_slice_yield
"""
_FIRST_COMMON = 424
_PROCESSORS = {"x86_64": (0xC000003E, _X86_64), "aarch64": (0xC00000B7, _ARM64)}


def processor() -> int:
    """Return the number of this processor for seccomp, 0 of one that is not known here."""
    return _PROCESSORS.get(os.uname().machine, (0, ""))[0]


@cache
def numbers(machine: str = "") -> dict[str, int]:
    """Return the calls of a machine, by default this one, and their numbers."""
    _, own = _PROCESSORS[machine or os.uname().machine]
    found = {name: number for number, name in enumerate(own.split()) if name != "-"}
    return found | {name: _FIRST_COMMON + n for n, name in enumerate(_COMMON.split())}


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
VARIABLES: tuple[str, ...] = ("PATH", "HOME", "LANG", "LANGUAGE", "TZ")
VARIABLES += ("TMPDIR", "XDG_CACHE_HOME", "LD_LIBRARY_PATH")
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
    """What is allowed besides."""

    folders: tuple[str, ...] = ()  # that may be read and written
    words: frozenset[str] = frozenset()  # NETWORK, EXEC
    variables: frozenset[str] = frozenset()  # of the environment

    @classmethod
    def of(cls, allow: Iterable[str]) -> Self:
        """Return what the words of ``--allow`` mean; ValueError when one has no meaning."""
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
                expected = "'network', 'exec' or 'files=DIR', or 'env=NAME'"
                raise ValueError(f"allow is {word!r}, expected {expected}")
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

    ``readable`` and ``writable`` are paths, with all below them, ``allow`` is of NETWORK and EXEC,
    ``file`` the descriptor of the socket whose other end a Guard has. ``code`` is the filter of
    system calls without the number of this process, which the call numbered ``seccomp`` installs.
    OSError when the kernel refuses, or there are other threads, which would stay outside.
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
    call: Callable[..., int],
    readable: Iterable[str],
    writable: Iterable[str],
    allow: frozenset[str],
) -> None:
    version = _landlock()
    everything = _ALL | (_REFER if version > 1 else 0) | (_TRUNCATE if version > 2 else 0)
    closed = NETWORK not in allow
    scopes = _SIGNALS | _ABSTRACT_SOCKETS * closed
    rules = struct.pack("<QQQ", everything, _CONNECTIONS * closed, scopes)
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
