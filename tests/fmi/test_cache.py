"""Built files lie in the folder the user chose."""

from __future__ import annotations

import sys

import pytest

from stickslip.fmi.toolchain import cache_directory


def test_the_cache_lies_where_the_environment_says(monkeypatch, tmp_path):
    monkeypatch.setenv("STICKSLIP_CACHE", str(tmp_path / "here"))
    assert cache_directory() == tmp_path / "here"


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
