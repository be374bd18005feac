"""Section 2.4 on the drive FMU: what the three stages find."""

from dataclasses import replace

import numpy as np
import pytest

from stickslip.catalog.parameters import PAPER, correlation_length, covariance
from stickslip.errors import IdentificationError
from stickslip.identification.stages import identify
from stickslip.identification.stages.friction_map import SPEEDS
from stickslip.servo.axis import LOOP
from tests.kept import further

DRIVES = [
    {"m": 12.0, "F_c": 2.0, "F_s": 2.2, "sigma_0": 1e5, "noise": True, "seed": 5},
    *further(
        {"m": 3.0, "F_c": 2.0, "F_s": 4.0, "sigma_0": 1e6},
        {"m": 12.0, "F_c": 12.0, "F_s": 13.2, "sigma_0": 1e5},
        {"m": 7.0, "F_c": 12.0, "F_s": 24.0, "sigma_0": 1e6},
    ),
]


@pytest.mark.slow
@pytest.mark.parametrize("truth", DRIVES, ids=str)
def test_values_lie_near_the_drives(make_rig, truth):
    found = identify(make_rig(**truth), LOOP).estimates
    drive = PAPER | truth
    for name, tolerance in {"m": 0.02, "F_c": 0.05, "sigma_0": 0.15}.items():
        assert found[name].value == pytest.approx(drive[name], rel=tolerance), name
    assert all(np.isfinite(e.standard_error) for e in found.values())


UNLIKE = {
    "all": {"asymmetric": True, "position_dependent": True, "ripple": True, "noise": True},
    "ripple": {"ripple": True, "ripple_amplitude": 2.0, "asymmetric": True, "asymmetry": 0.25},
    "guide": {"position_dependent": True, "position_amplitude": 0.3, "position_period": 0.05},
    "heavy": {"m": 8.0, "F_c": 4.0, "ripple": True, "noise": True, "position_dependent": True},
}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["all", *further("guide", "ripple", "heavy")])
def test_what_depends_on_position_does_not_pass_for_friction_over_velocity(make_rig, name):
    """Ripple cancels between the directions; friction varies alike at all speeds."""
    found = identify(make_rig(**UNLIKE[name]), LOOP).estimates
    drive = PAPER | UNLIKE[name]
    tolerances = {"m": 0.02, "b": 0.05, "F_c": 0.005, "F_s": 0.02, "v_s": 0.05, "sigma_0": 0.1}
    for name, tolerance in tolerances.items():
        assert found[name].value == pytest.approx(drive[name], rel=tolerance), name


@pytest.mark.slow
@pytest.mark.parametrize("noise_x", [2e-7, *further(0.0, 1e-7)])
def test_the_static_friction_does_not_depend_on_the_noise_of_the_encoder(make_rig, noise_x):
    """In the loop noise makes a slow velocity fluctuate, and the mean force of bristles fall.

    Break-away does not send the stage along metres.
    """
    rig = make_rig(noise=True, noise_x=noise_x)
    pushed, push = [], rig.push

    def watch(force):
        log = push(force)
        pushed.append(np.ptp(log.x_enc))
        return log

    rig.push = watch
    found = identify(rig, LOOP).estimates
    assert max(pushed) < 0.5
    assert found["F_s"].value == pytest.approx(PAPER["F_s"], rel=0.01)
    assert found["v_s"].value == pytest.approx(PAPER["v_s"], rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("truth", "sheet"),
    [({"m": 0.05}, {"tau_i": 3e-4}), *further(({"F_s": 100.0}, {}), ({"m": 0.05}, {}))],
)
def test_speeds_at_which_a_stage_sticks_and_slips_do_not_count(make_rig, truth, sheet):
    """A light stage in the same loop is held by less force for each metre that it lags."""
    rig = make_rig(**truth)
    rig.datasheet = replace(rig.datasheet, **sheet)
    found = identify(rig, LOOP)
    drive = PAPER | truth
    tolerances = {"m": 0.02, "b": 0.1, "F_c": 0.005, "v_s": 0.2}
    for name, tolerance in tolerances.items():
        assert found.estimates[name].value == pytest.approx(drive[name], rel=tolerance), name
    assert found.friction.velocity[-1] == SPEEDS[-1]
    assert len(found.friction.velocity) < 2 * len(SPEEDS)


UNKNOWN = {
    "held": ({"F_c": 500.0, "F_s": 500.0}, "inertia: the fit gives .* kg; a force of 61.5 N"),
    "hardly slides": ({"F_c": 60.0, "F_s": 70.0}, "mass does not show: check peak_force"),
    "coarse": ({"encoder_step": 1e-3}, "changes by 0.001 m at least; expected steps of 4e-07 m"),
}
SOFT = {"sigma_0": 1e4}, "mass does not show: check peak_force"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("truth", "told"), [*UNKNOWN.values(), *further(SOFT)], ids=[*UNKNOWN, "soft"]
)
def test_what_the_experiments_do_not_show_is_an_error(make_rig, truth, told):
    with pytest.raises(IdentificationError, match=told):
        identify(make_rig(**truth), LOOP)


@pytest.mark.slow
def test_a_stribeck_velocity_beyond_all_speeds_is_a_start_value(make_rig):
    found = identify(make_rig(v_s=0.1), LOOP)
    assert "shows no v_s at 0.00025 to 0.04 m/s" in found.warnings[0]
    assert found.estimates["v_s"].standard_error > found.estimates["v_s"].value


def test_correlation_length_is_that_of_a_first_order_process():
    phi, rng = 0.8, np.random.default_rng(0)
    noise = rng.standard_normal(400_000)
    process = np.zeros_like(noise)
    for k in range(1, len(noise)):
        process[k] = phi * process[k - 1] + noise[k]
    for lags in (None, 100):
        assert correlation_length(process, lags) == pytest.approx((1 + phi) / (1 - phi), rel=0.1)
    assert correlation_length(noise) == pytest.approx(1.0, abs=0.1)


def test_covariance_is_the_scatter_of_repeated_fits():
    rng = np.random.default_rng(1)
    regressors = rng.standard_normal((200, 2)) * [1.0, 5.0]
    truth = np.array([2.0, -1.0])
    fits, predicted = [], []
    for _ in range(400):
        data = regressors @ truth + 0.3 * rng.standard_normal(200)
        fit = np.linalg.lstsq(regressors, data, rcond=None)[0]
        fits.append(fit)
        predicted.append(np.sqrt(np.diag(covariance(regressors, data - regressors @ fit))))
    assert np.mean(predicted, axis=0) == pytest.approx(np.std(fits, axis=0), rel=0.15)
