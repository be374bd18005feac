"""Section 2.4 on the drive FMU: what the three stages find."""

import numpy as np
import pytest

from stickslip.errors import IdentificationError
from stickslip.identification import identify
from stickslip.identification.estimate import correlation_length, covariance
from stickslip.parameters import PAPER
from stickslip.setup import LOOP

DRIVES = [
    {},
    {"m": 3.0, "F_c": 2.0, "F_s": 4.0, "sigma_0": 1e6},
    {"m": 12.0, "F_c": 12.0, "F_s": 13.2, "sigma_0": 1e5},
    {"m": 7.0, "F_c": 12.0, "F_s": 24.0, "sigma_0": 1e6},
    {"m": 12.0, "F_c": 2.0, "F_s": 2.2, "sigma_0": 1e5, "noise": True, "seed": 5},
]


@pytest.mark.parametrize("truth", DRIVES, ids=str)
def test_values_lie_near_the_drives(make_rig, truth):
    found = identify(make_rig(**truth), LOOP).estimates
    drive = PAPER | truth
    for name, tolerance in {"m": 0.02, "F_c": 0.05, "sigma_0": 0.15}.items():
        assert found[name].value == pytest.approx(drive[name], rel=tolerance), name
    assert all(np.isfinite(e.standard_error) for e in found.values())


def test_a_drive_unlike_its_model_is_still_identified(make_rig):
    rig = make_rig(asymmetric=True, position_dependent=True, ripple=True, noise=True)
    found = identify(rig, LOOP).estimates
    assert found["m"].value == pytest.approx(PAPER["m"], rel=0.02)
    assert found["F_c"].value == pytest.approx(PAPER["F_c"], rel=0.2)


def test_a_stage_that_does_not_move_is_told(make_rig):
    with pytest.raises(IdentificationError, match=r"inertia: .* N"):
        identify(make_rig(F_c=500.0, F_s=500.0), LOOP)


def test_correlation_length_is_that_of_a_first_order_process():
    phi, rng = 0.8, np.random.default_rng(0)
    noise = rng.standard_normal(400_000)
    process = np.zeros_like(noise)
    for k in range(1, len(noise)):
        process[k] = phi * process[k - 1] + noise[k]
    assert correlation_length(process) == pytest.approx((1 + phi) / (1 - phi), rel=0.1)
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
