"""Each parser refuses what it does not take in its own words; campaigns/fuzz hunts longer."""

import logging

import pytest

from campaigns.fuzz import PARSERS, campaign

pytestmark = pytest.mark.slow

N = {"mat": 20}  # each starts a process
N |= dict.fromkeys(("description", "library", "csv", "json", "state", "toml"), 800)
REFUSED = {"parquet": 1, "log_csv": 1}
"""Of the inputs that all others are made from: texts in Parquet are no inputs, though a log may
hold them; a log without names must be described."""


@pytest.mark.parametrize("name", sorted(PARSERS))
def test_mutated_inputs_are_taken_or_refused(name, tmp_path, caplog):
    caplog.set_level(logging.CRITICAL)
    parser = PARSERS[name]
    tally = campaign.run(parser, seed=0, first=0, last=N.get(name, 100), folder=tmp_path)
    assert tally.unexpected == []
    assert tally.accepted > 0
    assert tally.refused > 0


@pytest.mark.parametrize("name", sorted(PARSERS.keys() - {"description"}))
def test_what_the_inputs_are_made_from_is_read(name, tmp_path):
    """Else all that is made of it would be refused for one reason."""
    parser, refused = PARSERS[name], 0
    for data in parser.corpus():
        try:
            parser.parse(data, tmp_path)
        except parser.expected:
            refused += 1
    assert refused == REFUSED.get(name, 0)
