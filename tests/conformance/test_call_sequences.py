"""Random calls under sanitizers: no crash, an error changes nothing, twice gives the same.

The rules are in tests/corpus/fuzz_calls/sequences.c; `python -m tests.corpus.fuzz_calls` runs more.
"""

from __future__ import annotations

import pytest

from tests.corpus.fuzz_calls import Fuzzer

pytestmark = pytest.mark.slow

SEQUENCES = 500


def test_random_calls(fmu, compiler, tmp_path):
    if "+" in fmu.target:
        pytest.skip("a model with another law has the same adapter and the same memory")
    thorough = fmu.target in ("stage", "velocity_controller")
    count = SEQUENCES * (10 if thorough else 1)
    fuzzer = Fuzzer.build(compiler, fmu.model, fmu.version, tmp_path)
    found = fuzzer.run(1, count)
    assert not found.fault
    assert found.unlawful > 10 * count
    assert found.calls - found.unlawful > 10 * count
    assert fuzzer.run(7, 100).digest == fuzzer.run(7, 100).digest != fuzzer.run(8, 100).digest
