"""The reference.csv beside each model is what make_references.py calculates."""

import numpy as np
import pandas as pd
import pytest

from stickslip import models
from stickslip.models.export.presentation import reference_file
from tests.models import make_references as references

SLOW = {"stage", "drive", "lugre_observer"}
NAMES = [
    name
    for name in (*models.law_names(), *models.model_names())
    if name not in SLOW and hasattr(references, name)
]


# Those of stage, drive and lugre_observer take seconds; tests/conformance holds them.
@pytest.mark.parametrize("name", NAMES)
def test_reference_is_up_to_date(name):
    fresh = pd.DataFrame(getattr(references, name)(references.start_values(name)))
    kept = pd.read_csv(reference_file(references.model_of(name)))
    assert list(kept) == list(fresh)
    # Matrix exponentials of two processors were seen to differ by 1e-11.
    np.testing.assert_allclose(kept, fresh, rtol=1e-10, atol=1e-12)
