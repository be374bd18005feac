"""The inverse model in rows, means of consecutive samples; a drive in other units is the same."""

from dataclasses import replace

import numpy as np
import pytest

from stickslip.identification.criteria import inverse_model
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.motion import Scale, scale_of
from stickslip.identification.fitting.fit import ROUGH, fit
from stickslip.identification.fitting.start import begin
from stickslip.logs import Recording
from tests.stickslip.identification.drives import STAGE, recording

T_S = 1e-4


def recorded(step):
    """Return a log of sines and creep of 4 s with this step of the encoder [m], and noisy force."""
    t = np.arange(40_000) * T_S
    v_cmd = 0.012 * np.sin(2.0 * np.pi * (0.4 + 0.15 * t) * t) * np.sin(0.5 * t) + 4e-4
    return recording("lugre", v_cmd, noise=0.5, T_s=T_S, tau_f=T_S, encoder=step)


def fitted(candidates, recording, q=None):
    """Return the fit of a law in rows, the number of samples in a row, and of rows."""
    with InverseModel(candidates, recording, q=q) as model:
        start = begin(model, recording)
        criterion = model.over(start.space)
        return fit(criterion, [start.space.encode(start.line)], ROUGH), model.q, len(model.t)


@pytest.mark.slow
@pytest.mark.thorough
def test_rows_give_the_values_of_the_samples_with_fewer_steps_of_the_law(candidates):
    recording = recorded(step=2e-9)
    (every, _, steps), (rows, q, fewer) = (fitted(candidates, recording, n) for n in (1, None))
    assert q > 1
    assert fewer == steps // q
    for name in ("m", "F_c", "F_s", "v_s", "sigma_0", "F_0"):
        error = np.hypot(every.errors()[name], rows.errors()[name])
        assert abs(rows.parameters[name] - every.parameters[name]) < 3.0 * error, name
        assert rows.errors()[name] < 1.2 * every.errors()[name], name


@pytest.mark.slow
def test_rows_keep_the_mass_that_a_coarse_encoder_dilutes(candidates):
    recording = recorded(step=4e-7)
    every, rows = (fitted(candidates, recording, n)[0] for n in (1, None))
    assert every.parameters["m"] < 0.2 * STAGE["m"]
    for name in ("m", "F_c", "F_s", "v_s", "sigma_0"):
        assert abs(rows.parameters[name] - STAGE[name]) < 3.0 * rows.errors()[name], name


def test_common_drives_are_left_alone_and_others_brought_near():
    assert scale_of(np.full(9, 30.0), np.full(9, 0.04)) == Scale()
    scale = scale_of(np.full(9, 0.02), np.full(9, 60.0))
    assert scale.force * 0.02 == pytest.approx(10.0, rel=3.0)
    assert 1e-2 < scale.length * 60.0 < 0.2
    assert np.log10(scale.force) % 1.0 == 0.0
    values = {"m": 2e-4, "b": 1e-4, "F_c": 0.02}
    assert scale.restored(scale.values(values)) == pytest.approx(values)
    assert scale.values(values)["F_c"] == pytest.approx(0.02 * scale.force)


def test_a_recording_is_scaled_and_back():
    t = np.arange(5.0)
    lengths = ("position", "velocity", "position_command", "velocity_command", "added_velocity")
    forces = ("force", "friction", "force_command", "added_force")
    recording = Recording(t, **dict.fromkeys((*lengths, *forces), t + 1.0), encoder_step=0.1)
    there = Scale(10.0, 100.0).recording(recording)
    assert there.encoder_step == pytest.approx(10.0)
    for name in (*lengths, *forces):
        factor = 100.0 if name in lengths else 10.0
        np.testing.assert_allclose(getattr(there, name), factor * (t + 1.0))
    assert Scale(0.1, 0.01).recording(replace(there, force=None)).force is None


def test_friction_at_rest_has_the_sign_with_which_the_drive_stopped(candidates, monkeypatch):
    """A low-pass alone makes it swing back by more than its contact bends."""
    v_cmd = 0.05 * np.repeat([0, 1, 0, -1, 0, 1, -1, 0], 250)
    quick = {"sigma_0": 4e5, "sigma_1": 2e4, "K_p": 700.0, "K_i": 2e4, "T_s": 1e-3}
    true = {**STAGE, **quick, "F_0": 0.0, "delay": 0.0, "delta": 1.0}
    names = ("m", "b", "F_s", "F_c", "v_s", "sigma_0", "sigma_1", "F_0", "delay", "delta")
    left = []
    for cutoffs in (inverse_model.QUICKER, ()):
        monkeypatch.setattr(inverse_model, "QUICKER", cutoffs)
        with InverseModel(candidates, recording("lugre", v_cmd, **quick)) as inverse:
            residual = inverse.residual({name: true[name] for name in names})
        left.append(np.sqrt(np.mean(residual**2)))
    assert left[0] < 0.1 * true["F_c"]
    assert left[1] > 0.3 * true["F_c"]
