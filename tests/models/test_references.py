"""The reference.csv beside each model is what make_references.py calculates."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from stickslip import models
from stickslip.models.export.presentation import reference_file

CALCULATED = (
    *("velocity_controller", "velocity_filter", "nominal_loop", "static_feedforward", "dob"),
    *("coulomb_observer", "momentum_observer", "lugre_observer", "lffc", "rbf", "mlp"),
    "lugre_network",
    *("adaptive_scale", "command_feedforward", "command_static"),
)


# Those of stage and drive take seconds; tests/conformance holds them against the models.
@pytest.mark.parametrize("name", [*models.law_names(), *CALCULATED])
def test_reference_is_up_to_date(name):
    script = runpy.run_path(str(Path(__file__).with_name("make_references.py")))
    fresh = pd.DataFrame(script[name](script["start_values"](name)))
    kept = pd.read_csv(reference_file(script["model_of"](name)))
    assert list(kept) == list(fresh)
    # Matrix exponentials of two processors were seen to differ by 1e-11.
    np.testing.assert_allclose(kept, fresh, rtol=1e-10, atol=1e-12)
