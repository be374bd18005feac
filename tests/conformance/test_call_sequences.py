"""Whatever is called, in whatever order: no crash, errors leave no trace, twice gives the same.

The laws are in tests/corpus/fuzz_calls/sequences.c; `python -m tests.corpus.fuzz_calls` runs more.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.corpus.fuzz_calls import Fuzzer

pytestmark = pytest.mark.slow

SEQUENCES = 5000


@pytest.mark.parametrize("version", [2, 3], ids=["fmi2", "fmi3"])
@pytest.mark.parametrize("model", ["stage", "velocity_controller"])
def test_random_calls(compiler: str, tmp_path: Path, model: str, version: int):
    fuzzer = Fuzzer.build(compiler, model, version, tmp_path)
    found = fuzzer.run(1, SEQUENCES)
    assert not found.fault
    assert found.unlawful > 10 * SEQUENCES
    assert found.calls - found.unlawful > 10 * SEQUENCES
    assert fuzzer.run(7, 100).digest == fuzzer.run(7, 100).digest != fuzzer.run(8, 100).digest
