"""A delay that was put in is found again, to a fraction of a sample."""

from dataclasses import replace

import numpy as np
import pytest
from rigid_drive import rigid_drive

from stickslip.logs import Recording, aligned, force_delay, samples_late, signal_delay
from stickslip.logs.force_path import force_path
from stickslip.planning import LINEAR, Limits, plan
from stickslip.servo.measurement import smoothed


@pytest.mark.parametrize("delay", [0.0, 0.25, -0.6, 1.0, 3.4, 12.0])
def test_of_a_rigid_drive_with_a_noisy_force(delay):
    drive = rigid_drive(n=6000, delay=delay, step=4e-7)
    noise = 0.05 * np.random.default_rng(0).standard_normal(len(drive.t))
    found = force_delay(replace(drive, force=drive.force + noise))
    assert found.value / drive.T_s == pytest.approx(delay, abs=0.03)
    assert found.known(drive.T_s)
    assert abs(found.value / drive.T_s - delay) < 5 * found.standard_error / drive.T_s


@pytest.fixture(scope="module")
def log(drive_log) -> Recording:
    """Half a standard plan, run on the paper's drive."""
    return drive_log(plan(Limits(duration=10.0))["velocity_command"].to_numpy())


def test_between_channels(log):
    v = smoothed(np.gradient(log.position, log.T_s), log.T_s, 50.0)
    late = np.interp(log.t - 2.3 * log.T_s, log.t, 1.7 * v + 0.01)
    found = signal_delay(log.t, v, late)
    assert found.value / log.T_s == pytest.approx(2.3, abs=0.1)
    assert LINEAR.speed > np.abs(v).max() * 0.5


def test_what_shows_no_delay(log):
    assert force_delay(replace(log, force=None)) is None
    steady = Recording(log.t, 0.01 * log.t, 5.0 + 0.0 * log.t)
    found = force_delay(steady)
    assert found is None or not found.known(log.T_s)
    noise = np.random.default_rng(0).standard_normal(len(log.t))
    found = force_delay(replace(log, force=noise))
    assert found is None or not found.known(log.T_s)


@pytest.mark.parametrize("late", [0, 12, -5])
@pytest.mark.parametrize(("mass", "viscous"), [(3.0, 60.0), (3.2, 44.0), (1.0, 20.0)])
def test_of_a_force_that_switches(mass, viscous, late):
    """A wrong delay with a negative mass, or Coulomb friction alone, explains it best."""
    t = np.arange(20000) * 1e-3
    force = 18.6 * np.sign(np.sin(2 * np.pi * (0.3 * t + 0.04 * t**2)))
    x = v = 0.0
    position = []
    for F in np.repeat(force, 10):
        w = v + 1e-4 * (F - viscous * v) / mass
        v = np.sign(w) * max(abs(w) - 1e-4 * 7.6 / mass, 0.0)
        x += 1e-4 * v
        position.append(x)
    shown = np.round(np.array(position[9::10]) / 1e-7) * 1e-7
    logged = force[np.clip(np.arange(20000) - late, 0, None).clip(max=19999)]
    drive = Recording(t, shown, logged, encoder_step=1e-7)
    found = force_delay(drive)
    assert found.value / 1e-3 == pytest.approx(late + 0.55, abs=0.1)  # held forces show half late
    assert not list(force_path(aligned(drive, samples_late(drive))))
