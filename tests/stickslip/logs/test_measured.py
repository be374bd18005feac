"""Measured logs through the configurations in examples/logs."""

from pathlib import Path

import numpy as np
import pytest

from stickslip.logs import check_recording, load_description, read_recording
from stickslip.logs.motion import kinematics
from stickslip.servo.measurement import smoothed

LOGS = Path(__file__).resolve().parents[3] / "examples" / "logs"


def test_emps(emps):
    reading = read_recording(emps, load_description(LOGS / "emps.toml"))
    recording = reading.recording
    assert not reading.findings
    assert len(recording.t) == 24_841
    assert recording.T_s == pytest.approx(1e-3, rel=1e-4)
    assert recording.encoder_step == pytest.approx(5e-8, rel=1e-6)
    assert np.ptp(recording.position) == pytest.approx(0.246, abs=0.001)
    assert reading.controller.K_x == pytest.approx(160.18)
    assert reading.controller.K_p == pytest.approx(243.45 * 35.1507, rel=1e-5)
    findings = "\n".join(map(str, check_recording(recording, reading.controller)))
    assert "m is identifiable" in findings
    assert "F_s and v_s are poorly identifiable" in findings
    assert "sigma_0 and sigma_1 are poorly identifiable" in findings
    assert "error" not in findings


def test_the_force_of_emps_is_that_of_its_publishers(emps):
    """M a + F_v v + F_c sign(v) + offset, from all samples as they did: units and scale hold."""
    recording = read_recording(emps, load_description(LOGS / "emps.toml")).recording
    motion = kinematics(recording, 50.0)
    force = smoothed(recording.force, recording.T_s, motion.cutoff)
    columns = np.column_stack([motion.a, motion.v, np.sign(motion.v), np.ones(len(force))])
    fit = np.linalg.lstsq(columns, force, rcond=None)[0]
    np.testing.assert_allclose(fit, [95.1089, 203.5034, 20.3935, -3.1648], rtol=0.01)


def test_the_controller_of_emps_gives_the_force_it_logged(emps):
    """Scale, gains and the law itself: u = K_p (K_x e_x - v)."""
    reading = read_recording(emps, load_description(LOGS / "emps.toml"))
    recording, controller = reading.recording, reading.controller
    e_x = recording.position_command - recording.position
    v = np.gradient(recording.position, recording.T_s)
    u = controller.K_p * (controller.K_x * e_x - v)
    residual = smoothed(recording.force - u, recording.T_s, 50.0)
    assert np.std(residual) < 0.15 * np.std(recording.force)


def test_tribometer(tribometer):
    reading = read_recording(tribometer, load_description(LOGS / "tribometer.toml"))
    recording = reading.recording
    assert recording.force is None
    assert recording.T_s == pytest.approx(5e-3, rel=1e-4)
    assert recording.encoder_step == pytest.approx(1e-7, rel=1e-6)
    assert np.ptp(recording.position) == pytest.approx(2.4e-4, rel=0.01)
    findings = "\n".join(map(str, (*reading.findings, *check_recording(recording))))
    assert "regular clock, rounded: a row each 0.005 s, in steps of 0.001 s" in findings
    assert "99 velocity reversals" in findings


def test_sound_logs_neither_saturate_nor_jump(emps, tribometer):
    """The peaks of the force of EMPS are rounded, not cut off."""
    for path, name in ((emps, "emps.toml"), (tribometer, "tribometer.toml")):
        reading = read_recording(path, load_description(LOGS / name))
        found = (*reading.findings, *check_recording(reading.recording, reading.controller))
        assert not any(finding.spoils for finding in found)
