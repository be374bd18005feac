"""No file makes the checker itself fail; tests/hostile/test_fuzz.py changes descriptions."""

import random

import pytest

from stickslip import fmucheck
from stickslip.fmucheck.description.model import number
from tests.corpus.defects.reference import members, pack


@pytest.mark.parametrize("seed", range(40))
def test_any_bytes_give_a_report(tmp_path, seed):
    """Bytes of a sound FMU changed at random places, its end cut off or not."""
    chance = random.Random(seed)  # noqa: S311 (no secret)
    data = bytearray(pack(tmp_path / "a.fmu", members(2)).read_bytes())
    for _ in range(chance.randint(1, 30)):
        data[chance.randrange(len(data))] = chance.randrange(256)
    path = tmp_path / "b.fmu"
    path.write_bytes(data[: chance.randint(1, len(data))] if seed % 2 else data)
    report = fmucheck.check(path, run=False)
    assert [f.severity for f in report] == sorted((f.severity for f in report), reverse=True)


def test_nothing_is_left_and_nothing_leaves_the_folder(tmp_path, monkeypatch):
    """Temporary files are gone whether the FMU is sound or its paths go up."""
    room = tmp_path / "room"
    room.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(room))
    outside = "terminalsAndIcons/../../../../../../../../etc/hostname"
    names = ("../../evil", "/tmp/fmucheck-evil", outside)  # noqa: S108 (not written)
    report = fmucheck.check(pack(tmp_path / "evil.fmu", members(2) | dict.fromkeys(names, b"")))
    (unsafe,) = (f for f in report if f.rule == "unsafe-path")
    assert {unsafe.place, *unsafe.others} == {repr(name) for name in names}
    assert list(room.iterdir()) == []
    assert sorted(p.name for p in tmp_path.iterdir()) == ["evil.fmu", "room"]


def test_digits_without_end_are_no_number():
    """A pattern with two ways to divide them would be at it for hours."""
    assert number("9" * 1_000_000 + "x") is None
    assert number("9" * 300 + ".5e0") == float("9" * 300)
