"""Each law predicts the parts of a recording that it was not fitted to, beside a regression."""

from types import SimpleNamespace

import numpy as np
import pytest

from stickslip.identification.criteria.controller_check import ControllerCheck
from stickslip.identification.held_out import blocks, folds, is_less
from stickslip.identification.selection import prediction
from stickslip.identification.selection.folds import moving
from stickslip.identification.selection.prediction import predictions
from stickslip.planning import Limits, plan
from tests.kept import further
from tests.stickslip.identification.drives import STAGE, recording

N, T_S, MEMORY = 8000, 1e-3, 10
T = T_S * np.arange(N)
V = 0.04 * np.sin(2.0 * np.pi * T)
RIGID = np.column_stack([np.gradient(V, T_S), V, np.ones(N)])
MOVES = np.abs(V) > 4e-3
NOISE = 0.05 * np.random.default_rng(1).standard_normal(N)
FRICTION = 4.0 * np.tanh(V / 1e-4)


def compared(residual, force):
    """Compare a residual with the regression of a force; the drive has 2 kg and 3 N s/m."""
    inverse = SimpleNamespace(
        moves=MOVES,
        used=slice(0, N),
        motion=SimpleNamespace(v=V),
        T_s=T_S,
        cutoff=100.0,
        measures_friction=False,
        linear=RIGID,
        measured=lambda _: force,
    )
    return moving(inverse, {}, residual, folds(N, MEMORY))


FORCE = RIGID @ [2.0, 3.0, 0.2] + FRICTION + NOISE
STRIBECK = 3.0 * np.exp(-np.abs(V) / 0.01) * np.sign(V)


@pytest.mark.parametrize(
    ("residual", "force", "fails"),
    [
        (NOISE, FORCE, False),  # as good as the regression
        (NOISE + 0.3 * FRICTION, FORCE, True),  # friction 30 % wrong
        (NOISE, FORCE + STRIBECK, False),  # better than the regression
        (NOISE + np.where(MOVES, 0.0, 5.0), FORCE, False),  # wrong at rest only
        (NOISE + 0.3 * (blocks(N) == 7), FORCE, False),  # one block is not the rule
    ],
)
def test_a_law_fails_where_the_regression_is_better_beyond_chance(residual, force, fails):
    found = compared(residual, force)
    assert found.fails == fails
    assert found.law == pytest.approx(np.sqrt(np.mean(residual[MOVES] ** 2)))


def test_the_regression_predicts_what_it_was_not_fitted_to():
    """Its error is that of the noise, a little more, and grows where one block is another drive."""
    alike = compared(NOISE, FORCE).regression
    assert alike == pytest.approx(0.05, rel=0.1)
    other = FORCE + 2.0 * np.isin(blocks(N), np.arange(0, 40, 5))
    fitted = np.linalg.lstsq(np.column_stack([np.sign(V), RIGID])[MOVES], other[MOVES])[0]
    rest = (other - np.column_stack([np.sign(V), RIGID]) @ fitted)[MOVES]
    assert compared(NOISE, other).regression > 1.05 * np.sqrt(np.mean(rest**2))


@pytest.mark.filterwarnings("error")
def test_each_fold_of_a_short_recording_leaves_something_to_fit_and_one_block_decides_nothing():
    assert not is_less(np.array([0.1]), np.array([0.9]))
    for n in (600, 1100, 2700, 40_000):
        split = list(folds(n, 65))
        assert all(fold.fitted.sum() > 65 for fold in split)
        assert np.all(sum(fold.held_out.astype(int) for fold in split) == 1)


COMMAND = plan(Limits(duration=5.0))["velocity_command"].to_numpy()
DAMPING = {"dahl": {"sigma_1": 0.0}}


@pytest.fixture(scope="module", params=("dahl", *further("lugre", "gms")))
def predicted(request):
    found = predictions(recording(request.param, COMMAND, **DAMPING.get(request.param, {})))
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
