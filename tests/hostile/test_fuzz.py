"""Each parser refuses what it does not take in its own words; campaigns/fuzz.py hunts longer."""

import logging

import pytest

from campaigns.fuzz import PARSERS, run

pytestmark = pytest.mark.slow

N = {"mat": 20, "ssp": 50}  # each starts a process, or unpacks two FMUs
TEXTS = ("description", "csv", "config", "learned", "checkpoint")
N |= dict.fromkeys((*TEXTS, "library", "state"), 500)


@pytest.mark.parametrize("name", PARSERS)
def test_mutated_inputs_are_taken_or_refused(name, tmp_path, caplog):
    caplog.set_level(logging.CRITICAL)
    parser = PARSERS[name]
    for data in parser.sound():  # else all that is made of it would be refused for one reason
        file = tmp_path / parser.file
        file.write_bytes(data)
        parser.read(file)
    tally = run(parser, 0, range(N.get(name, 100)))
    assert not tally.unexpected
    assert tally.accepted > 0
    assert tally.refused > 0
