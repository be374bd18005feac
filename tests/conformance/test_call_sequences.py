"""Random calls under sanitizers: no crash, an error changes nothing, twice gives the same.

The rules are in tests/conformance/fuzz_calls/sequences.c.
A model with another law has the same adapter and the same memory, so each runs with its own, and
with one that has state events. What
FMI 2.0 and 3.0 do not share sees the tables of a model only: where two models have variables of the
same kinds, one of them runs with FMI 2.0, too.
"""

from dataclasses import replace

import pytest

from stickslip import models
from tests.conformance.fuzz_calls import Fuzzer

pytestmark = pytest.mark.slow

SEQUENCES = 500
MODELS = [models.load_model(name) for name in models.model_names()]
MODELS.append(replace(models.load_model("stage", "gms"), name="stage_gms"))
KINDS = {
    frozenset((v.role, v.type, v.variability, v.is_output, v.held) for v in model.variables): model
    for model in MODELS
}
CASES = [(model, 3) for model in MODELS] + [(model, 2) for model in KINDS.values()]


USUAL = {("stage", 3), ("stage_gms", 3), ("lugre_network", 3), ("drive", 2)}
USUAL |= {("velocity_controller", 2)}
"""Models whose calls are tried in every run of the tests; compiling a fuzzer takes a second."""


@pytest.mark.parametrize(
    ("model", "version"),
    [
        pytest.param(
            model,
            version,
            id=f"{model.name}-fmi{version}",
            marks=() if (model.name, version) in USUAL else pytest.mark.thorough,
        )
        for model, version in CASES
    ],
)
def test_random_calls(model, version, compiler, tmp_path):
    thorough = model.name in ("stage", "velocity_controller")
    count = SEQUENCES * (10 if thorough else 1)
    fuzzer = Fuzzer.build(compiler, model, version, tmp_path)
    found = fuzzer.run(1, count)
    assert not found.fault
    assert found.unlawful > 10 * count
    assert found.calls - found.unlawful > 10 * count
    assert fuzzer.run(7, 100).digest == fuzzer.run(7, 100).digest != fuzzer.run(8, 100).digest
