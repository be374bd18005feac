"""Counters that restart are counted on, lost samples filled in, and other jumps are errors."""

import re

import numpy as np
import pandas as pd
import pytest

from stickslip.logs import Description, Recording, read_recording
from tests.stickslip.logs.rigid_drive import rigid_drive

STEP = 4e-7
DRIVE = rigid_drive(n=6000, step=STEP)
COUNTS = np.round(DRIVE.position / STEP)
TURN = 2 * np.pi


@pytest.fixture
def read(read_log):
    """Return a function that reads a log of the drive with other columns: recording, findings."""

    def run(head="t [s],x [m],F [N]", **columns):
        columns = {"t": DRIVE.t, "x": DRIVE.position, "F": DRIVE.force} | columns
        table = pd.DataFrame(columns)
        table.columns = head.split(",")
        reading = read_log(table.to_csv(index=False), strict=False)
        return reading.recording, "\n".join(map(str, reading.findings))

    return run


def moved(recording: Recording, expected, rtol=1e-9) -> None:
    """Check a position but for its constant."""
    x, expected = (one - one[0] for one in (recording.position, expected))
    np.testing.assert_allclose(x, expected, rtol=0, atol=rtol * np.ptp(expected))


def wrapped(x, size, low=0.0):
    return (x - low) % size + low


@pytest.mark.parametrize("word", [2**12, 2**14, 12_345])
@pytest.mark.parametrize("step", [STEP, 1.2345678e-6])
def test_a_counter_that_restarts_is_counted_on(read, word, step):
    """An overflow of signed or unsigned counts, and a modulo axis of any length."""
    for low in (0, -word // 2):
        recording, found = read(x=step * wrapped(COUNTS, word, low))
        moved(recording, step * COUNTS)
        times = np.sum(np.abs(np.diff(wrapped(COUNTS, word, low))) > word / 2)
        assert (
            f"position restarts, and was counted on: {1e3 * word * step:.6g} mm, {times} times"
            in found
        )


@pytest.mark.parametrize("size", [0.01, 0.0123])
def test_a_modulo_axis_without_encoder_steps(read, size):
    drive = rigid_drive(n=6000)
    command = wrapped(drive.position + 1e-5, size)
    head = "t [s],x [m],F [N],x_cmd [m]"
    recording, found = read(head, x=wrapped(drive.position, size), c=command)
    moved(recording, drive.position)
    np.testing.assert_allclose(recording.position_command - recording.position, 1e-5, atol=1e-9)
    assert f"{1e3 * size:g} mm" in found


@pytest.mark.parametrize("low", [0.0, -180.0])
def test_full_turns(read, low):
    angle = DRIVE.position / 0.01 * 360.0
    recording, found = read("t [s],angle [deg],torque [N.m]", x=wrapped(angle, 360.0, low))
    moved(recording, np.radians(angle))
    assert recording.motion == "rotary"
    assert "position restarts, and was counted on: 6.28319 rad" in found


def test_a_velocity_that_overflows(read):
    counts = np.round(DRIVE.velocity / 1e-5)
    head = "t [s],x [m],F [N],v [m/s]"
    recording, found = read(head, v=1e-5 * wrapped(counts, 2**15, -(2**14)))
    np.testing.assert_allclose(recording.velocity, 1e-5 * counts, atol=1e-9)
    assert "velocity restarts, and was counted on: 327.68 mm/s" in found
    square = 0.1 * np.sign(np.sin(8 * DRIVE.t)) + 1e-5 * np.round(20 * np.sin(60 * DRIVE.t))
    recording, found = read(head, v=square)
    np.testing.assert_array_equal(recording.velocity, square)


@pytest.mark.parametrize("length", [1, 3])
def test_samples_that_are_lost_are_filled_in(read, length):
    rows = np.add.outer(np.arange(300, 5700, 180), np.arange(length)).ravel()
    zero = np.isin(np.arange(6000), rows)
    x = np.where(zero, 0.0, DRIVE.position + 0.3)
    recording, found = read(x=x, F=np.where(zero, 0.0, DRIVE.force))
    assert np.max(np.abs(recording.position - DRIVE.position - 0.3)) < 3 * STEP
    assert (
        f"position: samples are lost, which jump there and back: {len(rows)}, the first in row 302"
        in found
    )
    smooth = np.abs(DRIVE.velocity) > 0.02
    assert np.max(np.abs(recording.force - DRIVE.force)[smooth]) < 0.5


@pytest.mark.parametrize("size", [-0.5, 2e-3, -1.5e-3])
@pytest.mark.parametrize("times", [1, 3])
def test_another_jump_is_an_error_with_its_row_size_and_remedy(read, tmp_path, size, times):
    """An encoder that is set back, and a new zero point."""
    at = (4000, 1000, 2000)[:times]
    x = DRIVE.position + sum(size / (k + 1) * (DRIVE.t >= DRIVE.t[row]) for k, row in enumerate(at))
    found = read(x=x)[1]
    assert "error: the position jumps" in found
    told = re.search(r"by (\S+) (mm|µm) in row 4002", found)
    assert float(told[1]) * {"mm": 1e-3, "µm": 1e-6}[told[2]] == pytest.approx(size, rel=0.01)
    begin, end = map(float, re.search(r"span=\((\S+), (\S+),\) is", found).groups())
    reading = read_recording(tmp_path / "log.csv", Description(span=(begin, end)))
    assert not any("jumps" in str(finding) for finding in reading.findings)
    assert len(reading.recording.t) > 6000 / (times + 1) - 10


def slipping(t, slip=0.012, every=0.7):
    """Return the velocity of a drive that rests, and slips within some milliseconds."""
    phase = t % every
    return np.where(phase < slip, 0.05 * np.sin(np.pi * phase / slip) ** 2, 0.0)


SOUND = {
    "fast at 200 Hz": (5e-3, 1e-6, lambda t: 2.0 * np.clip(30 * np.sin(2 * np.pi * t), -1, 1)),
    "steps of speed": (1e-3, 1e-7, lambda t: 0.5 * np.sign(np.sin(2 * np.pi * 3 * t))),
    "20 kHz": (5e-5, 1e-8, lambda t: 0.3 * np.sin(2 * np.pi * 5 * t)),
    "coarse encoder": (1e-3, 1e-4, lambda t: 0.01 * np.sin(2 * np.pi * t)),
    "creep over encoder steps": (1e-3, 1e-6, lambda t: 2e-5 * np.sin(t)),
    "stick-slip at 1 kHz": (1e-3, 1e-6, slipping),
    "stick-slip at 500 Hz": (2e-3, 1e-7, slipping),
}


@pytest.mark.parametrize("name", SOUND)
def test_a_sound_position_does_not_jump(read, name):
    T_s, step, motion = SOUND[name]
    t = np.arange(min(20_000, round(20 / T_s))) * T_s
    x = step * np.round(np.cumsum(motion(t)) * T_s / step)
    recording, found = read(t=t, x=x, F=np.sin(t))
    np.testing.assert_allclose(recording.position, x, rtol=1e-12)
    assert not re.search("jump|restart|lost", found)
