"""What changed the force between drive and log is named, with its figure."""

from dataclasses import replace

import numpy as np
import pytest
from rigid_drive import rigid_drive
from scipy.signal import lfilter

from stickslip.logs import check_recording

DRIVE = rigid_drive(n=8000, step=4e-7)
NOISE = 0.05 * np.random.default_rng(3).standard_normal(len(DRIVE.t))


def spoiled(force, recording=DRIVE):
    found = check_recording(replace(recording, force=force))
    return [str(finding) for finding in found if finding.spoils]


def test_a_sound_force_has_no_fault():
    assert spoiled(DRIVE.force + NOISE) == []


@pytest.mark.parametrize("step", [2e-5, 1e-4])
def test_steps_of_the_encoder_are_no_low_pass(step):
    """They make a rough acceleration, which every low-pass smooths."""
    drive = rigid_drive(n=8000, step=step)
    assert spoiled(drive.force, drive) == []


@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_a_force_that_the_log_cuts_off(noise):
    """Noise of the sensor comes before or behind the limit."""
    limit = float(np.quantile(np.abs(DRIVE.force), 0.88))
    for force in (
        np.clip(DRIVE.force, -limit, limit) + noise * NOISE,
        np.clip(DRIVE.force + noise * NOISE, -limit, limit),
    ):
        [found] = spoiled(force)
        assert "the force in the log is cut off" in found
        assert float(found.split(": ")[2].split(" for ")[0]) == pytest.approx(limit, rel=0.02)


@pytest.mark.parametrize("frequency", [5.0, 16.0])
@pytest.mark.parametrize("m", [1.0, 3.0, 10.0])
def test_a_force_that_was_low_passed(frequency, m):
    drive = rigid_drive(n=8000, step=4e-7, m=m)
    share = -np.expm1(-2.0 * np.pi * frequency * drive.T_s)
    [found] = spoiled(lfilter([share], [1.0, share - 1.0], drive.force), drive)
    assert "the force in the log is low-passed" in found
    told = float(found.split("at ")[1].split(" Hz")[0])
    assert told == pytest.approx(frequency, rel=0.35)


def test_a_delay_is_not_a_low_pass():
    for delay in (2.0, 7.5, 20.0):
        assert spoiled(rigid_drive(n=8000, delay=delay, step=4e-7).force) == []


@pytest.mark.parametrize("delay", [120, -120])
def test_a_delay_beyond_the_search_is_named(delay):
    """120 ms of a sweep up to 4 Hz."""
    drive = rigid_drive(n=8000, delay=delay, step=4e-7)
    found = [one for one in spoiled(drive.force) if "delay" in one]
    assert len(found) == 1
    assert f"{np.copysign(100, delay):g} ms, the largest that is looked for" in found[0]


def test_presliding_is_no_low_pass():
    """Its force is that of a spring, like that of a negative mass."""
    assert spoiled(500.0 * DRIVE.position + NOISE) == []
