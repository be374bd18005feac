"""Figures that hardly any drive has are errors until they are corrected or confirmed."""

import numpy as np
import pandas as pd
import pytest
from rigid_drive import rigid_drive

STATED = ("time [s]", "position [m]", "force [N]")


@pytest.fixture
def check(check_log):
    """Return a function that checks a log of a rigid drive: status, errors, standard output."""

    def run(*options, header=STATED, m=3.0, size=1.0, period=1e-3):
        drive = rigid_drive(n=4000, m=m, b=0.0, F_c=0.3 * m)
        columns = (drive.t * period / 1e-3, drive.position * size, drive.force)
        return check_log(pd.DataFrame(dict(zip(header, columns, strict=True))), *options)[:3]

    return run


@pytest.mark.parametrize("m", [2e-3, 3.0, 5e4])
def test_a_usual_mass_is_accepted(check, m):
    assert check(m=m)[:2] == (0, [])


@pytest.mark.parametrize("m", [2.4e-4, 5e-7, 2e5, 1e6])
def test_an_extreme_mass_must_be_confirmed(check, m):
    status, errors, _ = check(m=m)
    assert status == 1
    assert len(errors) == 1
    assert float(errors[0].split(": ")[2].split(" kg")[0]) == pytest.approx(m, rel=0.01)
    assert "--unit" in errors[0]
    assert "--confirm mass" in errors[0]
    confirmed = check("--confirm", "mass", m=m)
    assert confirmed[:2] == (0, [])
    assert "mass is extreme, and confirmed" in confirmed[2]


def test_a_small_moment_of_inertia_is_usual(check):
    header = ("time [s]", "angle [rad]", "torque [N.m]")
    assert check(m=2e-6, header=header)[:2] == (0, [])
    assert "kg m^2" in check(m=2e-11, header=header)[1][0]


def test_speed_and_acceleration_are_reported_together(check):
    """0.3 m/s and 6 m/s^2 at most, in mm read as m by mistake and in nm."""
    status, errors, _ = check(size=1e4)
    assert status == 1
    assert any("speed" in line and "--confirm speed" in line for line in errors)
    assert any("acceleration" in line and "--confirm acceleration" in line for line in errors)
    assert check("--confirm", "speed", "acceleration", "mass", size=1e4)[:2] == (0, [])
    assert check("--confirm", "speed", "mass", size=1e4)[0] == 1
    assert check("--unit", "position=mm", size=1e4)[0] == 0


def test_a_long_travel_without_a_unit_must_be_confirmed(check):
    header = ("time", "position", "force")
    status, errors, _ = check(header=header, size=1e3)
    assert status == 1
    assert "40 m" in errors[0]
    assert "--unit position=mm" in errors[0]
    assert check("--unit", "position=mm", header=header, size=1e3)[0] == 0
    long = check("--unit", "position=m", "--confirm", "speed", header=header, size=1e3)
    assert long[:2] == (0, [])


def test_slow_sampling_without_a_unit_must_be_confirmed(check):
    header = ("time", "position [m]", "force [N]")
    status, errors, _ = check(header=header, period=0.99)
    assert status == 1
    assert "--unit time=ms" in errors[0]
    assert check("--unit", "time=ms", header=header, period=0.99)[0] == 0
    stated = check("--unit", "time=s", "--confirm", "mass", header=header, period=0.99)
    assert stated[:2] == (0, [])


def test_a_configuration_confirms_too(check, tmp_path):
    path = tmp_path / "log.toml"
    path.write_text('confirm = ["mass"]\n')
    assert check("--config", str(path), m=1e-5)[0] == 0
    path.write_text('confirm = ["mas"]\n')
    assert check("--config", str(path), m=1e-5)[0] == 1
    path.write_text("confirm = 3\n")
    assert check("--config", str(path), m=1e-5)[0] == 1


def test_a_mass_that_is_not_identifiable_may_be_extreme(check_log):
    """Constant friction and noise only: the fit of m may be anything."""
    drive = rigid_drive(n=4000, m=0.0, b=0.0, F_c=4.0)
    noise = np.random.default_rng(1).normal(0, 0.5, len(drive.t))
    columns = zip(STATED, (drive.t, drive.position, drive.force + noise), strict=True)
    status, _, out, _ = check_log(pd.DataFrame(dict(columns)))
    assert status == 0
    assert "--confirm" not in out


@pytest.mark.parametrize(
    ("change", "name"),
    [({"m": 1e-2}, "mass"), ({"m": 5e4}, "force"), ({"size": 80.0}, "speed")],
)
def test_an_unusual_figure_is_asked_about(check, change, name):
    status, errors, out = check(**change)
    assert (status, errors) == (0, [])
    [line] = [line for line in out.splitlines() if f"the {name} is unusual" in line]
    assert line.startswith("warning: ")
    assert f"--confirm {name}" in line
    assert f"the {name} is unusual" not in check("--confirm", name, **change)[2]


def test_a_force_against_the_motion_is_an_error(check):
    status, errors, _ = check("--scale", "force=-1")
    assert status == 1
    assert "the force acts against the motion" in errors[0]
    assert "--scale force=-1*-1" in errors[0] or "--scale force=-1" in errors[0]
    assert check("--scale", "force=-1*-1")[:2] == (0, [])


def test_a_force_that_does_work_on_the_motion_is_not_against_it(check_log):
    """Bristles before the drive slides: their stiffness looks like a negative mass."""
    t = np.arange(8000) * 5e-4
    x, v, drag = 1e-5 * np.sin(10.0 * t), 1e-4 * np.cos(10.0 * t), 2e5
    log = pd.DataFrame(
        dict(zip(STATED, (t, x, 2e6 * x + drag * v - 5.0 * np.sign(v)), strict=True))
    )
    assert not any("against" in line for line in check_log(log)[1])
