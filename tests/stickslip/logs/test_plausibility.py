"""Figures that hardly any drive has are errors until they are corrected or confirmed."""

import numpy as np
import pandas as pd
import pytest
from rigid_drive import rigid_drive

STATED = ("time [s]", "position [m]", "force [N]")
ROTARY = ("time [s]", "angle [rad]", "torque [N.m]")


@pytest.fixture
def check(check_log):
    """Return a function that checks a log of a rigid drive: status, errors, standard output."""

    def run(options="", header=STATED, m=3.0, size=1.0, period=1e-3):
        drive = rigid_drive(n=4000, m=m, b=0.0, F_c=0.3 * m)
        columns = (drive.t * period / 1e-3, drive.position * size, drive.force)
        table = pd.DataFrame(dict(zip(header, columns, strict=True)))
        return check_log(table, *options.split())[:3]

    return run


@pytest.mark.parametrize(
    "drive", [{"m": 2e-3}, {"m": 3.0}, {"m": 5e4}, {"m": 2e-6, "header": ROTARY}], ids=str
)
def test_a_usual_mass_is_accepted(check, drive):
    assert check(**drive)[:2] == (0, [])


@pytest.mark.parametrize("m", [2.4e-4, 5e-7, 2e5, 1e6])
def test_an_extreme_mass_is_named_and_confirmed(check, m):
    [error] = check(m=m)[1]
    assert float(error.split(": ")[2].split(" kg")[0]) == pytest.approx(m, rel=0.01)
    assert "mass is extreme, and confirmed" in check("--confirm mass", m=m)[2]


EXTREME = {
    "a mass": ({"m": 5e-7}, ("--unit", "--confirm mass"), ("--confirm mass",)),
    "an inertia": ({"m": 2e-11, "header": ROTARY}, ("kg m^2",), ("--confirm mass",)),
    "speed and acceleration": (  # 0.3 m/s and 6 m/s^2, in mm read as m by mistake and in nm
        {"size": 1e4}, ("--confirm speed", "--confirm acceleration"),
        ("--confirm speed acceleration mass", "--unit position=mm"),
    ),
    "a long travel without a unit": (
        {"header": ("time", "position", "force"), "size": 1e3}, ("40 m", "--unit position=mm"),
        ("--unit position=mm", "--unit position=m --confirm speed"),
    ),
    "slow sampling without a unit": (
        {"header": ("time", *STATED[1:]), "period": 0.99}, ("--unit time=ms",),
        ("--unit time=ms", "--unit time=s --confirm mass"),
    ),
    "a force against the motion": (
        {"options": "--scale force=-1"}, ("acts against the motion", "--scale force=-1*-1"),
        ("--scale force=-1*-1",),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", EXTREME)
def test_what_is_extreme_must_be_confirmed_or_corrected(check, name):
    given, words, answers = EXTREME[name]
    status, errors, _ = check(**given)
    assert status == 1
    for word in words:
        assert any(word in line for line in errors)
    for options in answers:
        assert check(**{**given, "options": options})[:2] == (0, [])


def test_one_figure_that_is_confirmed_leaves_the_others(check):
    assert check("--confirm speed mass", size=1e4)[0] == 1


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
    assert f"the {name} is unusual" not in check(f"--confirm {name}", **change)[2]


def test_a_force_that_does_work_on_the_motion_is_not_against_it(check_log):
    """Bristles before the drive slides: their stiffness looks like a negative mass."""
    t = np.arange(8000) * 5e-4
    x, v, drag = 1e-5 * np.sin(10.0 * t), 1e-4 * np.cos(10.0 * t), 2e5
    log = pd.DataFrame(
        dict(zip(STATED, (t, x, 2e6 * x + drag * v - 5.0 * np.sign(v)), strict=True))
    )
    assert not any("against" in line for line in check_log(log)[1])
