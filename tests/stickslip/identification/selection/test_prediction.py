"""Each law predicts the parts of a recording that it was not fitted to."""

import numpy as np
import pytest
from drives import STAGE, run

from stickslip.identification.criteria.controller_check import ControllerCheck
from stickslip.identification.selection import prediction, predictions
from stickslip.logs import Recording
from stickslip.planning import plan
from tests.kept import further

COMMAND = plan()["velocity_command"].to_numpy()[:16_000]
DAMPING = {"dahl": {"sigma_1": 0.0}}


def recording(law, **changes):
    found = run(law, COMMAND, **{"uneven": 0.0, **changes})
    return Recording(found["t"], found["position"], found["applied"], encoder_step=4e-7)


@pytest.fixture(scope="module", params=("dahl", *further("lugre", "gms")))
def predicted(request):
    found = predictions(recording(request.param, **DAMPING.get(request.param, {})))
    return request.param, {one.candidate.title: one for one in found}


def test_the_law_of_the_drive_predicts_what_it_was_not_fitted_to(predicted):
    law, found = predicted
    best = min(found.values(), key=lambda one: one.force)
    (own,) = (one for one in found.values() if one.candidate.law.name == law)
    assert own.force < 1.05 * best.force
    assert own.parameters["m"] == pytest.approx(STAGE["m"], rel=0.03)
    assert own.parameters["F_c"] == pytest.approx(STAGE["F_c"], rel=0.03)
    # The elements of that GMS are five, and others than those of the catalogue.
    assert own.force < (2.5 if law == "gms" else 1.3) * own.explained
    assert float(np.sqrt(own.squares.mean())) == pytest.approx(own.force, rel=0.01)
    assert found["Coulomb-Stribeck with F_s = F_c"].force > 2.0 * own.force


def test_gains_of_a_controller_that_was_running_before_are_believed(monkeypatch):
    given = {"K_p": 1700.0, "F_held": 3.0, "F_fading": 0.1}
    asked = []

    def check(_, recording, gains):
        asked.append(dict(gains))
        return recording, ControllerCheck(np.zeros(1), 0.0, 0, given)

    monkeypatch.setattr(prediction, "check_controllers", check)
    assert prediction._believed(None, given) == (None, given)
    assert asked == [{"K_p": 1700.0}]
