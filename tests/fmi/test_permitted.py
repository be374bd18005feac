"""What code in the sandbox may never call, whoever extends the table of what it may."""

from stickslip.fmi.process.permitted import ALLOWED
from stickslip.fmi.process.sandbox import numbers

FORBIDDEN = """
    add_key bpf capset chown chroot fanotify_init fchown fchownat finit_module fremovexattr
    fsetxattr init_module inotify_add_watch inotify_init inotify_init1 io_uring_setup ioprio_set
    kcmp kexec_load keyctl lchown lremovexattr lsetxattr memfd_create mknod mknodat mlock
    mlockall mount mq_open msgget name_to_handle_at open_by_handle_at perf_event_open
    pidfd_getfd pidfd_open pidfd_send_signal pivot_root process_vm_readv process_vm_writev
    ptrace reboot removexattr request_key seccomp semget setgid setgroups setns setpgid
    setresgid setresuid setreuid setsid setuid setxattr shmat shmget splice swapon symlink
    symlinkat sync tee truncate umount2 unshare userfaultfd vmsplice
"""


def test_no_call_that_reaches_beyond_the_process_is_in_the_table():
    """tests/cosim/isolation interprets the filter that is made of it, for every call."""
    allowed = {name for rule in ALLOWED for name in rule.calls.split()}
    known = numbers("x86_64").keys() | numbers("aarch64").keys()
    assert known.issuperset(FORBIDDEN.split())
    assert allowed.isdisjoint(FORBIDDEN.split())
