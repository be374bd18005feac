"""A short version of ``python -m campaigns.fault_matrix``: nothing is confident and wrong."""

import pytest

from campaigns.fault_matrix.cells import check_all, learn_all
from campaigns.fault_matrix.faults import cases

pytestmark = [pytest.mark.slow, pytest.mark.thorough]

TOLD = {
    "none": "silent",
    "force clipped in the log": "values",
    "force logged before clipping": "values",
    "2 % of rows lost": "values",
    "force filtered at 16 Hz": "values",
    "one way only": "values",
    "position in mm read as m": "error",
    "mm and A read as m and N": "error",
    "time in ms read as s": "error",
    "command x 1000": "error",
    "velocity x 1000": "error",
    "velocity x 1.3": "values",
    "force inverted": "error",
}
"""What checking a log already says; with these, no compensator is written."""


def test_most_faults_are_found_before_learning():
    skipped = {("gms", 1, name) for name, fault in cases(list(TOLD)) if not fault.gains}
    rows = check_all(list(TOLD), skipped, "gms", 1)
    for row in rows:
        assert row["outcome"] == TOLD[row["fault"]], row
    assert len(rows) == len(TOLD) - 1


def test_another_controller_is_not_confident_and_wrong():
    [row] = learn_all(["cascade given as PI"], (), "dahl", 1)
    assert row["outcome"] != "confident and wrong", row
