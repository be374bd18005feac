"""Numbers in other units than the log was read in, or of no usual drive, are errors."""

import numpy as np
import pandas as pd
import pytest
from scipy import signal

import stickslip as ss
from stickslip.cli import main
from stickslip.logs import Description, read_and_check
from stickslip.logs.plausibility import correction
from tests.stickslip.logs.rigid_drive import rigid_drive

INCH, TURN = 0.0254, 2 * np.pi
GAINS = ("--controller", "PI", "--gain", "K_p=100", "K_i=100")
FORCE = ("time", "position", "force")


@pytest.fixture
def check(check_log):
    """Return a function that checks a log of a rigid drive: status, errors, output, errors.

    Columns are divided by the units of ``given``: {"position": 1e-3} writes them in mm.
    """

    def run(*options, step=0.0, names=(), only=None, whole=None, **given):
        drive = rigid_drive(n=2500, step=step)
        table = pd.DataFrame(
            {
                "time": drive.t,
                "position": drive.position,
                "velocity": drive.velocity,
                "position_command": drive.position,
                "velocity_command": drive.velocity,
                "force": drive.force,
            }
        )
        table = table / {name: given.get(name, 1.0) for name in table}
        if whole:
            table[whole] = table[whole].round()
        table = table[list(only)] if only else table
        return check_log(table.rename(columns=dict(names)), *options)

    return run


def test_consistent_signals_are_no_error(check):
    """A controller may run faster than its log."""
    status, errors, out, err = check(*GAINS, "T_s=3.125e-5", "--sample-period", "0.001")
    assert (status, errors, err) == (0, [], "")
    assert "differ in scale" not in out


def test_a_column_with_the_name_of_another_quantity_is_told(check):
    given = ("--column", "force=velocity_command", "--unit", "force=N")
    told = "warning: column 'velocity_command' is read as force"
    assert told in check(*given)[2]
    for usual in ("force=force", "velocity_command=velocity", "force=i"):
        assert "is read as" not in check("--column", usual, names={"force": "i"}.items())[2]


CONTRADICTIONS = {
    "position in mm": ({"position": 1e-3}, "10^3", "--unit position=mm"),
    "position in um": ({"position": 1e-6}, "10^6", "--unit position=um"),
    "position in inches": ({"position": INCH}, "39.37", "--unit position=inch"),
    "position in degrees": ({"position": TURN / 360}, "360/2 pi", "--unit position=deg"),
    "position in turns": ({"position": TURN}, "2 pi", "--unit position=rev"),
    "position in turns, velocity in deg/s": (
        {"position": TURN, "velocity": TURN / 360}, "360", "position=UNIT",
    ),
    "position command in mm": ({"position_command": 1e-3}, "10^3", "--unit position_command=mm"),
    "velocity in mm/s": ({"velocity": 1e-3}, "10^3", "--unit velocity=mm/s"),
    "velocity in rpm": ({"velocity": TURN / 60}, "60/2 pi", "--unit velocity=rpm"),
    "velocity command in mm/s": ({"velocity_command": 1e-3}, "10^3", "velocity_command=mm/s"),
    "time in ms": ({"time": 1e-3}, "10^3", "--unit time=ms"),
    "time in 1000 s": ({"time": 1e3}, "10^3", "--unit position=mm"),
    "velocity turned around": ({"velocity": -1}, "opposite signs", "--scale velocity=-1"),
    "position turned around": ({"position": -1}, "opposite signs", "--scale position=-1"),
}  # fmt: skip


@pytest.mark.parametrize("name", CONTRADICTIONS)
def test_a_factor_of_units_is_an_error_that_names_it(check, name):
    given, factor, option = CONTRADICTIONS[name]
    status, errors, _, err = check(**given)
    assert status == 1
    found = [line for line in errors if "contradict" in line and option in line]
    assert found
    assert factor in found[0]
    assert err.count("\n") == 1
    if option.startswith("--") and name != "time in 1000 s":
        assert check(*option.split(), **given)[:2] == (0, [])


STATED = {
    "iq": "current by its name",
    "Motorstrom": "current by its name",
    "courant": "current by its name",
    "u": "voltage by its name",
    "I_q [A]": "force is in A",
    "Strom_mA": "force is in mA",
    "torque [0.1 %]": "force is in ‰",
    "torque [‰ of rated]": "unit '‰ of rated' is unknown",
    "actual torque %": "percentage by its name",
    "tau": "torque by its name",
}
WRONG = {
    "a controller's T_s in ms": ("", {}, (*GAINS, "T_s=1.0"), "T_s", (*GAINS, "T_s=0.001")),
    **{
        f"a sample period of {given}": (
            "--sample-period 0.001", {}, ("--sample-period", given), "10^",
            ("--sample-period", "0.001", "--column", "time=none"),
        )
        for given in ("1", "1000", "1e-6")
    },
    **{
        f"an encoder step of {given}": (
            "--encoder-step", {"step": 4e-7}, ("--encoder-step", given), "10^3",
            ("--encoder-step", "4e-7"),
        )
        for given in ("4e-4", "4e-10")
    },
    **{
        f"whole numbers of {role}": (
            "", {"only": FORCE, "step": 1e-6, role: size, "whole": role}, (),
            f"{role}: column '{role}': whole numbers only", ("--unit", f"{role}={unit}"),
        )
        for role, unit, size in (("position", "um", 1e-6), ("time", "ms", 1e-3))
    },
    **{
        name: (
            "--scale force=", {"names": {"force": name}, "only": FORCE},
            ("--column", f"force={name.split(' [')[0]}"), said,
            ("--column", f"force={name.split(' [')[0]}", *right),
        )
        for name, said in STATED.items()
        for right in [("--unit", "force=N") if name == "iq" else ("--scale", "force=23")]
    },
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_named_with_an_option_and_accepted_when_right(check, name):
    """Another quantity than force needs a unit or a scale, and so do whole numbers."""
    option, given, wrong, said, right = WRONG[name]
    status, errors, *_ = check(*wrong, **given)
    assert status == 1
    assert said in errors[0]
    assert option in errors[0]
    assert check(*right, **given)[:2] == (0, [])


@pytest.mark.parametrize("factor", [5.0, 10.0, 50.0, 1 / 30])
def test_a_gear_is_a_warning_that_names_its_factor(check, factor):
    status, _, out, _ = check(velocity=1 / factor, velocity_command=1 / factor)
    assert status == 0
    measured = out.split("velocity is ")[1].split(" times d(position)/dt")[0]
    assert float(measured) == pytest.approx(factor, rel=0.005)
    scales = f"--scale=velocity={1 / factor}", f"--scale=velocity_command={1 / factor}"
    corrected = check(*scales, velocity=1 / factor, velocity_command=1 / factor)
    assert "differ in scale" not in corrected[2]


LOOPS = ((1.0, 0.2, 1.0), (1.0, 2.0, 0.5), (5.0, 0.7, 0.5), (20.0, 0.2, 0.5))
"""Bandwidth [Hz], damping and gain of controllers that follow badly."""


@pytest.mark.slow
def test_a_bad_controller_is_not_a_contradiction(check_log):
    """Second-order loops that lag, overshoot and lose half of their command."""
    t = np.arange(4000) * 1e-3
    command = 0.02 * np.sin(2 * np.pi * (0.2 * t + 0.2 * t**2))
    for bandwidth, damping, gain in LOOPS:
        w = 2 * np.pi * bandwidth
        loop = ([gain * w * w], [1, 2 * damping * w, w * w])
        b, a, _ = signal.cont2discrete(loop, 1e-3, "zoh")
        x = signal.lfilter(b.ravel(), a, command)
        table = {"time": t, "position": x, "position_command": command}
        table |= {"velocity_command": np.gradient(command, 1e-3), "force": np.sin(t)}
        assert "contradict" not in check_log(pd.DataFrame(table))[2]


OTHER = 0.05 * np.sin(2 * np.pi * 0.37 * np.arange(4000) * 1e-3)
SIGNALS = ("force", "velocity", "velocity_command", "position_command")


@pytest.mark.parametrize("name", SIGNALS)
def test_a_signal_that_is_unrelated_to_the_motion_is_an_error(check_log, name):
    """Those of another axis, and noise."""
    other = np.random.default_rng(0).standard_normal(4000) if name == "velocity" else OTHER
    drive = rigid_drive(n=4000, step=4e-7)
    table = {"time": drive.t, "position": drive.position, "force": drive.force}
    status, errors, *_ = check_log(pd.DataFrame(table | {name: other}))
    assert status == 1
    [found] = [line for line in errors if "unrelated" in line]
    assert found.startswith(f"error: {name} is unrelated to ")
    assert f"--column {name}=NAME" in found
    own = drive.velocity if "velocity" in name else table.get(name, drive.position)
    noise = 0.5 * np.std(own) * np.random.default_rng(1).standard_normal(4000)
    assert "unrelated" not in check_log(pd.DataFrame(table | {name: own + noise}))[2]


def test_a_ramp_of_force_up_to_break_away_is_of_the_axis(check_log):
    t = np.arange(4000) * 5e-3
    x = 1e-6 * t + 5e-4 * np.maximum(t - 17.0, 0.0) ** 2
    _, errors, *_ = check_log(pd.DataFrame({"time": t, "position": x, "force": 0.5 * t}))
    assert "unrelated" not in "".join(errors)


def test_all_errors_are_printed_and_learn_reports_the_first(check, tmp_path, capsys):
    status, errors, _, err = check(names={"force": "iq"}, position=1e-3, velocity_command=1e-3)
    assert status == 1
    assert len(errors) >= 4
    assert err.count("\n") == 1
    assert main(["learn", "--log", str(tmp_path / "log.csv"), "--out", str(tmp_path / "out")]) == 1
    assert capsys.readouterr().err.count("error: ") == 1
    assert not (tmp_path / "out" / "learned.json").exists()


HEADER = ("time [s]", "position [m]", "force [N]")
ROTARY = ("time [s]", "angle [rad]", "torque [N.m]")


@pytest.fixture
def check_size(check_log):
    """Return a function that checks a log of a rigid drive: status, errors, standard output."""

    def run(options="", header=HEADER, m=3.0, size=1.0, period=1e-3):
        drive = rigid_drive(n=2500, m=m, b=0.0, F_c=0.3 * m)
        columns = (drive.t * period / 1e-3, drive.position * size, drive.force)
        table = pd.DataFrame(dict(zip(header, columns, strict=True)))
        return check_log(table, *options.split())[:3]

    return run


def test_a_usual_mass_is_accepted_and_an_extreme_one_named_and_confirmed(check_size):
    for usual in ({"m": 2e-3}, {"m": 3.0}, {"m": 5e4}, {"m": 2e-6, "header": ROTARY}):
        assert check_size(**usual)[:2] == (0, [])
    for m in (2.4e-4, 5e-7, 2e5, 1e6):
        [error] = check_size(m=m)[1]
        assert float(error.split(": ")[2].split(" kg")[0]) == pytest.approx(m, rel=0.01)
        assert "mass is extreme, and confirmed" in check_size("--confirm mass", m=m)[2]


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
        {"header": ("time", *HEADER[1:]), "period": 0.99}, ("--unit time=ms",),
        ("--unit time=ms", "--unit time=s --confirm mass"),
    ),
    "a force against the motion": (
        {"options": "--scale force=-1"}, ("acts against the motion", "--scale force=-1*-1"),
        ("--scale force=-1*-1",),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", EXTREME)
def test_what_is_extreme_must_be_confirmed_or_corrected(check_size, name):
    given, words, answers = EXTREME[name]
    status, errors, _ = check_size(**given)
    assert status == 1
    for word in words:
        assert any(word in line for line in errors)
    for options in answers:
        assert check_size(**{**given, "options": options})[:2] == (0, [])
    if name == "speed and acceleration":  # what is confirmed leaves the others
        assert check_size("--confirm speed mass", **given)[0] == 1


def test_a_mass_that_is_not_identifiable_may_be_extreme(check_log):
    """Constant friction and noise only: the fit of m may be anything."""
    drive = rigid_drive(n=4000, m=0.0, b=0.0, F_c=4.0)
    noise = np.random.default_rng(1).normal(0, 0.5, len(drive.t))
    columns = zip(HEADER, (drive.t, drive.position, drive.force + noise), strict=True)
    status, _, out, _ = check_log(pd.DataFrame(dict(columns)))
    assert status == 0
    assert "--confirm" not in out


@pytest.mark.parametrize(
    ("change", "name"), [({"m": 1e-2}, "mass"), ({"m": 5e4}, "force"), ({"size": 80.0}, "speed")]
)
def test_an_unusual_figure_is_asked_about(check_size, change, name):
    status, errors, out = check_size(**change)
    assert (status, errors) == (0, [])
    [line] = [line for line in out.splitlines() if f"the {name} is unusual" in line]
    assert line.startswith("warning: ")
    assert f"--confirm {name}" in line
    assert f"the {name} is unusual" not in check_size(f"--confirm {name}", **change)[2]


def test_a_force_that_does_work_on_the_motion_is_not_against_it(check_log):
    """Bristles before the drive slides: their stiffness looks like a negative mass."""
    t = np.arange(8000) * 5e-4
    x, v, drag = 1e-5 * np.sin(10.0 * t), 1e-4 * np.cos(10.0 * t), 2e5
    log = pd.DataFrame(
        dict(zip(HEADER, (t, x, 2e6 * x + drag * v - 5.0 * np.sign(v)), strict=True))
    )
    assert not any("against" in line for line in check_log(log)[1])


@pytest.mark.parametrize(
    ("motion", "factor", "advice"),
    [
        ("rotary", 57.3, "<unit position=deg velocity=deg/s> or <scale force=57.3>"),
        ("linear", 1e3, "<unit position=mm velocity=mm/s> or <unit force=kN>"),
    ],
)
def test_what_a_controller_commands_in_other_units_of_the_motion_names_them(
    tmp_path, motion, factor, advice
):
    drive = rigid_drive(n=2500)
    columns = {"time": drive.t, "position": drive.position, "velocity": drive.velocity}
    pd.DataFrame(columns | {"force": drive.force}).to_csv(tmp_path / "log.csv", index=False)
    reading = read_and_check(tmp_path / "log.csv", Description(motion=motion))[0]
    assert correction(reading, factor) == f"{advice}, whichever is wrong"


def test_a_checked_log_prints_a_line_for_each_finding(tmp_path):
    drive, path = rigid_drive(n=2500), tmp_path / "log.csv"
    columns = {"time": drive.t, "position": drive.position, "force": -drive.force}
    pd.DataFrame(columns).to_csv(path, index=False)
    reading, findings = checked = ss.check_log(path)
    assert str(checked).splitlines() == [reading.recording.source, *map(str, findings)]
    assert "error: the force acts against the motion" in str(checked)
