"""One recording of the paper's drive, learned from once; drives of other laws."""

import pytest

from stickslip.identification.estimation import candidate_fmus
from stickslip.output import SILENT
from stickslip.papers.lugre.record import reproduce_from_recording
from stickslip.papers.lugre.reproduction import Options
from tests.kept import kept

TRUTH = {"m": 8.0, "F_c": 4.5, "F_s": 7.0, "sigma_0": 3e5, "v_s": 8e-4, "noise": 1.0}


@pytest.fixture(scope="session")
def recorded():
    """The record mode on a drive that differs from Table 2, with noise."""
    options = Options(truth=TRUTH)
    return kept("recorded", lambda fmus: reproduce_from_recording(options, fmus, SILENT))


@pytest.fixture(scope="session")
def candidates():
    with candidate_fmus() as folder:
        yield folder
