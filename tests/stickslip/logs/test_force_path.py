"""What changed the force between drive and log: a delay, a low-pass, a limit."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from campaigns.sound_drives import simulator
from stickslip.logs import Recording, aligned, check_recording, samples_late
from stickslip.logs.checks import saturation
from stickslip.logs.force_path import force_path
from stickslip.logs.motion import Delay, force_delay, signal_delay
from stickslip.servo.measurement import smoothed
from tests.kept import further
from tests.stickslip.logs.rigid_drive import rigid_drive

DRIVE = rigid_drive(n=8000, step=4e-7)
NOISE = 0.05 * np.random.default_rng(3).standard_normal(len(DRIVE.t))


def spoiled(force, recording=DRIVE):
    found = check_recording(replace(recording, force=force))
    return [str(finding) for finding in found if finding.spoils]


def test_a_sound_force_has_no_fault():
    assert spoiled(DRIVE.force + NOISE) == []
    assert samples_late(DRIVE) == 0
    assert not Delay(-6.0, 3.4).is_large(1.0)  # it may be none
    assert aligned(DRIVE, 0) is DRIVE


@pytest.mark.parametrize("samples", [10, -10, 40])
def test_a_delay_is_taken_out(samples):
    log = rigid_drive(n=8000, delay=samples, step=4e-7)
    late = samples_late(log)
    assert late == samples
    [said] = [str(finding) for finding in check_recording(log) if "removed" in finding.advice]
    assert said.startswith("warning: force is ")
    assert f"{abs(late)} ms are removed" in said
    again = aligned(log, late)
    assert samples_late(again) == 0
    assert len(again.t) == len(log.t) - abs(late)
    k = 1000 + max(-late, 0)
    assert again.position[1000] == log.position[k]
    assert again.force[1000] == log.force[k + late]


@pytest.mark.parametrize("share", [0.005, 0.02, 0.1])
def test_lost_rows_are_counted(share):
    rows = np.flatnonzero(np.random.default_rng(1).random(8000) >= share)
    kept = {"position": DRIVE.position[rows], "force": DRIVE.force[rows], "encoder_step": 4e-7}
    [said] = [one for one in check_recording(Recording(DRIVE.t[: len(rows)], **kept)) if one.spoils]
    assert said.what == "rows are lost under an even clock"
    assert float(said.figure.split("%")[0]) / 100.0 == pytest.approx(share, rel=0.2)


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


def test_a_delay_encoder_steps_and_presliding_are_no_low_pass():
    """Steps make a rough acceleration; the force of presliding is that of a negative mass."""
    for delay in (2.0, 7.5, 20.0):
        assert spoiled(rigid_drive(n=8000, delay=delay, step=4e-7).force) == []
    for step in (2e-5, 1e-4):
        drive = rigid_drive(n=8000, step=step)
        assert spoiled(drive.force, drive) == []
    assert spoiled(500.0 * DRIVE.position + NOISE) == []


@pytest.mark.parametrize("delay", [120, -120])
def test_a_delay_beyond_the_search_is_named(delay):
    """120 ms of a sweep up to 4 Hz."""
    drive = rigid_drive(n=8000, delay=delay, step=4e-7)
    found = [one for one in spoiled(drive.force) if "delay" in one]
    assert len(found) == 1
    assert f"{np.copysign(100, delay):g} ms, the largest that is looked for" in found[0]


@pytest.mark.parametrize("delay", [0.0, 0.25, -0.6, 1.0, 3.4, 12.0])
def test_of_a_rigid_drive_with_a_noisy_force(delay):
    drive = rigid_drive(n=6000, delay=delay, step=4e-7)
    noise = 0.05 * np.random.default_rng(0).standard_normal(len(drive.t))
    found = force_delay(replace(drive, force=drive.force + noise))
    assert found.value / drive.T_s == pytest.approx(delay, abs=0.03)
    assert found.known(drive.T_s)
    assert abs(found.value / drive.T_s - delay) < 5 * found.standard_error / drive.T_s


def test_between_channels():
    v = smoothed(np.gradient(DRIVE.position, DRIVE.T_s), DRIVE.T_s, 50.0)
    late = np.interp(DRIVE.t - 2.3 * DRIVE.T_s, DRIVE.t, 1.7 * v + 0.01)
    found = signal_delay(DRIVE.t, v, late)
    assert found.value / DRIVE.T_s == pytest.approx(2.3, abs=0.1)


def test_what_shows_no_delay():
    assert force_delay(replace(DRIVE, force=None)) is None
    steady = Recording(DRIVE.t, 0.01 * DRIVE.t, 5.0 + 0.0 * DRIVE.t)
    for log in (steady, replace(DRIVE, force=NOISE)):
        found = force_delay(log)
        assert found is None or not found.known(log.T_s)


@pytest.mark.parametrize(("mass", "viscous"), [(3.2, 44.0), *further((3.0, 60.0), (1.0, 20.0))])
def test_of_a_force_that_switches(mass, viscous):
    """A wrong delay with a negative mass, or Coulomb friction alone, explains it best."""
    t = np.arange(20000) * 1e-3
    force = 18.6 * np.sign(np.sin(2 * np.pi * (0.3 * t + 0.04 * t**2)))
    values = {"m": mass, "b": viscous, "F_c": 7.6, "F_s": 7.6, "v_s": 1.0, "T_s": 1e-3}
    values |= {"K_p": 0.0, "encoder": 1e-7}
    shown = simulator.run("coulomb_stribeck", values, 0.0 * t, F_ff=force)["encoder"][1:]
    for late in (0, 12, -5):  # held forces show half a sample late
        logged = force[np.clip(np.arange(19999) - late, 0, 19999)]
        drive = Recording(t[:-1], shown, logged, encoder_step=1e-7)
        assert force_delay(drive).value / 1e-3 == pytest.approx(late + 0.55, abs=0.1)
        prompt = aligned(drive, samples_late(drive))
        assert not list(force_path(prompt, force_delay(prompt)))


T_S, N = 1e-3, 8_000
T = np.arange(N) * T_S
SWEEP = 16.0 * np.sin(2 * np.pi * (0.3 * T + 0.04 * T**2))
TRAPEZOID = 0.1 * np.clip(8.0 * np.sin(2 * np.pi * 0.25 * T), -1.0, 1.0)


def run(force=None, b=0.0, limits=(-math.inf, math.inf)) -> Recording:
    """Return a log of a drive under a force (n,), or in a PI loop that follows ``TRAPEZOID``."""
    loop = {"K_p": 600.0, "K_i": 18000.0} if force is None else {}
    drive = {"m": 3.0, "b": b, "F_c": 6.0, "F_s": 6.0, "v_s": 1.0, "T_s": T_S, "encoder": 1e-7}
    drive |= dict(zip(("u_min", "u_max"), limits, strict=True))
    found = simulator.run("coulomb_stribeck", drive | loop, TRAPEZOID, F_ff=force)
    command = {"velocity_command": TRAPEZOID} if loop else {"force_command": found["commanded"]}
    return Recording(T, found["encoder"], found["force"], **command, encoder_step=1e-7)


def said(recording, **stated) -> str:
    found = check_recording(recording, **stated)
    return "\n".join(str(one) for one in found if "saturates" in one.what or "cut off" in one.what)


EXPERIMENTS = {
    "trapezoids with Coulomb friction alone": {},
    "bang-bang force": {"force": 14.0 * np.sign(SWEEP)},
    "steps of force": {
        "force": np.repeat([12, -9, 18, -18, 18, -10, 15, -12, 18, -18], N // 10) * 1.0, "b": 90.0,
    },
}  # fmt: skip


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_a_plateau_that_was_commanded_is_no_limit(name):
    """Its force stays at an extreme for a long time, in a log with and without the command."""
    log = run(**EXPERIMENTS[name])
    assert np.mean(np.abs(log.force) > 0.98 * np.quantile(np.abs(log.force), 0.98)) > 0.01
    for force in (log.force, np.round(log.force / 0.5) * 0.5):
        for change in ({}, {"force_command": None, "velocity_command": None}):
            assert said(replace(log, force=force, **change)) == ""


@pytest.mark.parametrize("limits", [(-7.5, 7.5), (-math.inf, 7.5), (-7.5, math.inf)])
def test_a_limit_is_found_where_the_error_of_the_motion_grows(limits):
    log = run(limits=limits)
    for size in (0.0, 0.03):
        noise = size * np.random.default_rng(0).standard_normal(N)
        noisy = replace(log, force=log.force + noise)
        found = said(noisy)
        assert float(found.split("saturates at ")[1].split(" N: ")[0]) == pytest.approx(
            7.5, rel=0.02
        )
        assert found == said(noisy, force_limit=60.0)  # the limit is lower than stated


def test_short_peaks_as_of_a_drive_that_slips_are_no_limit():
    """Each is so short that the largest thousandth of the force holds its flanks as well."""
    phase = np.arange(20000) % 500
    peak = 5.0 * np.exp(-(((phase - 250.0) / 10.0) ** 2)) * (1.0 + 2e-5 * np.arange(20000))
    t, force = 1e-3 * np.arange(20000), 3.0 + 1e-3 * phase
    log = Recording(t, np.zeros(20000), force + peak, force_command=force + 3.0 * peak)
    assert not [*saturation(log, None)]


def test_a_limit_that_is_exceeded_limits_nothing():
    """Such as one in N beside a force that is logged in mN."""
    log = run(SWEEP, b=90.0)
    mN = replace(log, force=1e3 * log.force, force_command=1e3 * log.force_command)
    found = [one.what for one in check_recording(mN, force_limit=13.0)]
    assert "force exceeds the force limit" in found
    assert not [one for one in found if "saturates" in one]


def test_a_limit_is_found_where_the_force_command_is_larger():
    log = run(SWEEP, b=90.0, limits=(-11.0, 13.0))
    told = said(log).split("saturates at 13 N: ")[1]
    share = np.mean((log.force > 12.8) | (log.force < -10.8))
    assert float(told.split("%")[0]) == pytest.approx(100 * share, rel=0.1)
    assert "saturates" not in said(replace(log, force_command=log.force))


def test_a_force_that_was_logged_before_a_limit():
    log = run(SWEEP, b=90.0, limits=(-13.0, 13.0))
    [found] = spoiled(log.force_command, replace(log, force_command=None))
    assert "the force was logged before a limit" in found
    assert float(found.split("at most ")[1].split(";")[0]) == pytest.approx(13.0, rel=0.1)
