"""Measured logs through the configurations in examples/logs."""

from pathlib import Path

import numpy as np
import pytest

from stickslip.logs import check_recording, load_description, read_recording

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
    assert not any(one.spoils for one in check_recording(recording, reading.controller))


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
    assert not any(one.spoils for one in check_recording(recording))
