"""A simulated loop that runs away gives no figure and no compensator, wherever it is run."""

from dataclasses import replace

import numpy as np
import pytest

from stickslip.catalog.parameters import PAPER, friction_law
from stickslip.cosim import SimulationError, Trapezoid
from stickslip.evaluation.comparison import Entry, evaluate
from stickslip.evaluation.motions import MOTIONS, VALIDATION
from stickslip.evaluation.tracking import LearnedDrive, simulate
from stickslip.evaluation.validation import validate
from stickslip.identification.criteria.controller_check import ControllerCheck
from stickslip.identification.criteria.goodness_of_fit import goodness_of_fit
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.runs import Diverged, require_bounded
from stickslip.identification.estimation import candidate_fmus
from stickslip.logs import Recording
from stickslip.servo.axis import LOOP, Datasheet
from stickslip.servo.velocity_loop import design_velocity_loop
from stickslip.thresholds.loop_fit import RUNS_AWAY
from stickslip.trial.benefit import Bench, feedforward
from stickslip.trial.family import Drive, commands
from tests.stickslip.evaluation.test_owner_loop import AXIS, COMPENSATOR, FRICTION, VALUES

UNSTABLE = {
    "gains ten times too high": {"K_p": 6e4, "K_i": 1e5},
    "gains of another unit": {"K_p": 6e6, "K_i": 1e7},
    "integral alone": {"K_p": 0.0, "K_i": 1e6},
}


@pytest.mark.parametrize("peak", [np.nan, np.inf, -1.01 * RUNS_AWAY, 1.01 * RUNS_AWAY])
def test_a_velocity_far_beyond_the_command_is_no_result(peak):
    v = np.array([0.0, peak, 1.0])
    with pytest.raises(Diverged, match="runs away"):
        require_bounded(v, 1.0)
    require_bounded(np.array([0.0, 0.99 * RUNS_AWAY]), 1.0)


@pytest.mark.parametrize("gains", UNSTABLE.values(), ids=UNSTABLE)
def test_the_loop_of_a_log_that_runs_away_has_neither_motion_nor_errors(gains):
    """The log itself is sound: a slow sine that the friction follows."""
    t = np.arange(4001) * LOOP.T_s
    v = 0.03 * np.sin(2.0 * np.pi * t)
    position = 0.03 * (1.0 - np.cos(2.0 * np.pi * t)) / (2.0 * np.pi)
    force = AXIS.m * np.gradient(v, t) + AXIS.b * v + PAPER["F_c"] * np.sign(v)
    recording = Recording(t, position, force=force, velocity_command=v, encoder_step=1e-7)
    gains = {**gains, "tau_f": LOOP.tau_f, "T_s": LOOP.T_s}
    check = ControllerCheck(force, 0.0, 0, gains)
    with candidate_fmus() as fmus, InverseModel(fmus, recording) as inverse:
        found = goodness_of_fit(inverse, VALUES, gains, check)
        with pytest.raises(Diverged):
            simulate(fmus, recording, gains, LearnedDrive("lugre", VALUES, COMPENSATOR))
    assert found.simulated is None
    assert np.isnan([found.position, found.velocity, found.closed_loop_force]).all()
    assert found.force < 0.5


def test_a_trial_that_runs_away_is_worse_than_none_and_says_so(loop, tmp_path):
    """A drive with a fiftieth of the mass in the loop that was designed for the whole."""
    light = Drive("a fiftieth of the mass", "lugre", {**FRICTION, "m": 0.02 * AXIS.m})
    tried = commands(Trapezoid(0.04, 0.4, 0.3, 0.1), loop.T_s, PAPER, 4e-7)[:1]
    sheet = Datasheet(peak_force=1e9)
    with_all = Bench(tmp_path, friction_law(), loop, [light], tried, datasheet=sheet)
    (benefit,) = with_all.benefits([feedforward(FRICTION)])
    with_all.close()
    assert not benefit.acceptable
    assert not any(np.isfinite([row.without, row.compensated]).any() for row in benefit.rows)
    assert "runs away" in benefit.reason
    assert "inf" not in benefit.refusal


def test_a_validation_that_runs_away_ends_in_one_line(loop, make_rig):
    rig = make_rig(m=0.05)
    with pytest.raises(SimulationError, match="runs away") as caught:
        validate(rig, loop, FRICTION, VALIDATION)
    assert "\n" not in str(caught.value)
    table = evaluate(rig, {"without": Entry(loop)}, motions=MOTIONS[:1]).table()
    assert table["without"].isna().all()


def test_stick_and_slip_is_no_divergence(make_rig):
    """A weak loop that sticks and slips in creep stays far below the limit."""
    soft = design_velocity_loop(AXIS, replace(LOOP, bandwidth=0.1 * LOOP.bandwidth))
    rig = make_rig(F_s=12.0)
    table = evaluate(rig, {"without": Entry(soft), "exact": Entry(soft, FRICTION)}).table()
    assert np.isfinite(table[["without", "exact"]]).all(axis=None)
