"""The beginning of the long hunt through what reads tables, logs, documents and packages.

``python -W error -m benchmarks.fuzz --parser NAME`` goes on from here.
"""

from __future__ import annotations

import pytest

from benchmarks.fuzz import campaign
from benchmarks.fuzz.parsers import load

PARSERS = ("csv", "fleet", "json", "log_csv", "mat", "parquet", "ssp", "state", "toml")


@pytest.mark.parametrize("name", PARSERS)
def test_no_input_ends_otherwise_than_it_should(name, tmp_path):
    if name == "parquet":
        pytest.importorskip("pyarrow")
    tally = campaign.run(load(name), seed=6, first=0, last=300, folder=tmp_path)
    assert not tally.unexpected
    assert tally.accepted > 10
    assert tally.refused > 100


@pytest.mark.parametrize("name", PARSERS)
def test_what_the_inputs_are_made_from_is_read(name, tmp_path):
    """Else all changes of it would be refused for the same reason."""
    if name == "parquet":
        pytest.importorskip("pyarrow")
    parser = load(name)
    refused = 0
    for data in parser.corpus():
        try:
            parser.parse(data, tmp_path)
        except parser.EXPECTED:
            refused += 1
    # as inputs are refused: texts in Parquet; and logs without names, unless they are described
    assert refused == {"parquet": 1, "log_csv": 1}.get(name, 0)
