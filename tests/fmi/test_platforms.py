"""What differs from machine to machine: names of platforms, the cache, futures of pools."""

import platform
import sys
from concurrent.futures import Future
from threading import Event

import pytest

from stickslip.fmi import toolchain
from stickslip.fmi.process import cancel_all, threads
from stickslip.fmi.toolchain import PLATFORMS, cache_directory, host_platform


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
