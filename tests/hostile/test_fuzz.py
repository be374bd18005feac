"""Each parser refuses what it does not take in its own words; the long hunt is benchmarks/fuzz."""

from __future__ import annotations

import logging

import pytest

from benchmarks.fuzz import campaign
from benchmarks.fuzz.parsers import NAMES, load

N = {"archive": 2000, "description": 2000}


@pytest.mark.parametrize("name", NAMES)
def test_mutated_inputs_are_taken_or_refused(name, tmp_path, caplog):
    caplog.set_level(logging.CRITICAL)
    parser = load(name)
    tally = campaign.run(parser, seed=0, first=0, last=N.get(name, 200), folder=tmp_path)
    assert tally.unexpected == []
    assert tally.accepted > 0
    assert tally.refused > 0


def test_an_unexpected_end_is_found_and_saved(tmp_path):
    class Careless:
        EXPECTED = (UnicodeDecodeError,)

        def corpus(self):
            return [b"1 2 3"]

        def parse(self, data, folder):  # noqa: ARG002
            sum(map(int, data.decode().split()))

    tally = campaign.run(Careless(), 0, 0, 200, tmp_path, found=tmp_path)
    assert tally.unexpected
    assert all("ValueError" in line for line in tally.unexpected)
    assert len(list(tmp_path.glob("*.bin"))) == len(tally.unexpected)
    assert tally.inputs == 200 == tally.accepted + tally.refused + len(tally.unexpected)


def test_a_hunt_goes_on_where_it_was(tmp_path, capsys, monkeypatch):
    parser = load("description")
    monkeypatch.setattr(campaign.faulthandler, "dump_traceback_later", lambda *_, **__: None)
    for inputs in (30, 50):
        campaign.resume(parser, 3, inputs, tmp_path / "state", tmp_path)
    whole = campaign.run(parser, 3, 0, 50, tmp_path)
    assert (
        f"50 inputs: {whole.accepted} accepted, {whole.refused} refused" in capsys.readouterr().out
    )
