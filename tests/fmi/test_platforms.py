"""What differs between machines: platforms, libraries, the cache, streams, and permitted calls."""

import hashlib
import platform
import struct
import sys
from concurrent.futures import Future
from threading import Event

import pytest

from stickslip import models
from stickslip.fmi import toolchain
from stickslip.fmi.process import cancel_all, threads
from stickslip.fmi.process.permitted import ALLOWED
from stickslip.fmi.process.sandbox import numbers
from stickslip.fmi.toolchain import (
    PLATFORMS,
    ToolchainError,
    cache_directory,
    host_platform,
    patched,
)
from tests.cosim.single import members


@pytest.mark.parametrize(
    ("system", "processor", "expected"),
    [
        ("linux", "x86_64", "x86_64-linux"),
        ("linux", "aarch64", "aarch64-linux"),
        ("win32", "AMD64", "x86_64-windows"),
        ("darwin", "arm64", "aarch64-darwin"),
    ],
)
def test_the_host_is_recognised(monkeypatch, system, processor, expected):
    monkeypatch.setattr(sys, "platform", system)
    monkeypatch.setattr(platform, "machine", lambda: processor)
    assert host_platform() is PLATFORMS[expected]


def test_an_unknown_host_is_named(monkeypatch):
    monkeypatch.setattr(platform, "machine", lambda: "riscv64")
    with pytest.raises(toolchain.ToolchainError, match=r"riscv64-\w+; FMUs run here on x86_64"):
        host_platform()


def test_platforms_are_chosen_by_name_and_each_once():
    every, host = [*PLATFORMS.values()], host_platform()
    assert toolchain.chosen_platforms(None) == toolchain.chosen_platforms("host") == [host]
    assert toolchain.chosen_platforms("all") == every
    assert toolchain.chosen_platforms(["host", host, host.tuple]) == [host]
    with pytest.raises(ToolchainError, match=r"expected all or of .*, host, got 'amiga'"):
        toolchain.chosen_platforms(["amiga"])


@pytest.mark.parametrize(
    ("system", "variable", "place"),
    [
        ("linux", "XDG_CACHE_HOME", "base/stickslip"),
        ("win32", "LOCALAPPDATA", "base/stickslip"),
        ("darwin", "HOME", "base/Library/Caches/stickslip"),
        ("linux", "HOME", "base/.cache/stickslip"),
    ],
)
@pytest.mark.skipif(sys.platform == "win32", reason="pretends other systems from a POSIX one")
def test_without_it_the_cache_is_the_users(monkeypatch, tmp_path, system, variable, place):
    monkeypatch.delenv("STICKSLIP_CACHE", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(sys, "platform", system)
    monkeypatch.setenv(variable, str(tmp_path / "base"))
    assert cache_directory() == tmp_path / place


class Lost(Future[None]):
    """A future of a cluster that does not answer."""

    def cancel(self) -> bool:
        Event().wait()
        return True


class Broken(Future[None]):
    """A future of a cluster that was closed."""

    def cancel(self) -> bool:
        raise RuntimeError("closed")


def test_cancelling_ends_though_a_future_does_not_answer(monkeypatch):
    monkeypatch.setattr(threads, "PATIENCE", 0.1)
    waiting = [Future[None]() for _ in range(2)]
    cancel_all(one for one in (waiting[0], Broken(), waiting[1], Lost()))
    assert all(one.cancelled() for one in waiting)


START_VALUES = {"A[1,1]": 4.25, "D": 1e-300}


def pages(library):
    """Yield the hash of each page, as signed and as it is: the code directory of a library."""
    place = 32
    for _ in range(struct.unpack_from("<I", library, 16)[0]):
        command, size, at = struct.unpack_from("<III", library, place)
        if command == 0x1D:
            break
        place += size
    else:
        return
    count = struct.unpack_from(">I", library, at + 8)[0]
    offsets = [struct.unpack_from(">I", library, at + 16 + 8 * k)[0] for k in range(count)]
    [code] = [
        at + one for one in offsets if library[at + one : at + one + 4] == b"\xfa\xde\x0c\x02"
    ]
    hashes, _, _, number, limit = struct.unpack_from(">5I", library, code + 16)
    page = 1 << library[code + 39]
    for k in range(number):
        signed = library[code + hashes + 32 * k : code + hashes + 32 * (k + 1)]
        yield signed, hashlib.sha256(library[k * page : min(limit, (k + 1) * page)]).digest()


@pytest.mark.parametrize(
    "platform", [p for p in PLATFORMS.values() if p.suffix == ".dylib"], ids=str
)
def test_the_signature_of_a_library_of_macos_holds(platform, tmp_path):
    fmu = models.build_fmu(
        "nominal_loop", tmp_path, fmi=3, platforms=[platform], start=START_VALUES
    )
    [library] = [data for name, data in members(fmu).items() if name.startswith("binaries/")]
    assert struct.pack("<d", 4.25) in library
    found = list(pages(library))
    assert found or "aarch64" not in platform.target
    assert all(signed == content for signed, content in found)


def test_a_library_without_the_place_is_refused():
    for library in (b"", b"here here"):
        with pytest.raises(ToolchainError, match=r"contains b'here' \d times"):
            patched(library, b"here", b"1")


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
