"""Headers that drives, robots and tools write: which column has which role.

``tool_headers.txt`` has one a row, behind a letter for each column: t is the time,
x v f are position, velocity and force, X V F their set points, A is an added force.
"""

from pathlib import Path

import numpy as np
import pytest

from stickslip.errors import RecordingError
from stickslip.logs import Description
from stickslip.logs.channels import unit_of
from stickslip.logs.roles import assign_roles
from stickslip.logs.table import LogTable, with_joined_times
from stickslip.logs.text import read_text
from stickslip.logs.units import unit_named

LETTERS = {
    "time": "t", "position": "x", "velocity": "v", "force": "f", "position_command": "X",
    "velocity_command": "V", "force_command": "F", "added_force": "A",
}  # fmt: skip
HEADERS = (Path(__file__).parent / "tool_headers.txt").read_text("utf-8").splitlines()


def written(header: str) -> bytes:
    """Return a log of 30 rows, time in steps of 1, the other columns all different."""
    columns = header.count(";")
    rows = ([k, *(np.sin(k * (j + 1)) for j in range(columns))] for k in range(30))
    return "\n".join([header, *(";".join(f"{v:.6f}" for v in row) for row in rows)]).encode()


@pytest.mark.parametrize("line", HEADERS)
def test_each_column_of_a_tool_has_its_role(line):
    letters, header = line.split(" ", 1)
    table = read_text("log", written(header), None, None)
    roles, remarks = assign_roles(table, Description())
    found = {table.names.index(name): LETTERS[role] for role, name in roles.items()}
    assert "".join(found.get(k, "-") for k in range(len(table.names))) == letters
    unused = [name for name, letter in zip(table.names, letters, strict=True) if letter == "-"]
    assert all(name in str(remarks[0]) for name in (*roles.values(), *unused[:8]))


AMBIGUOUS = {
    "t;field.position0;field.position1;effort": "position, field.position0 or field.p",
    "t;x;commanded_position;ipo_position": "position_command, commanded_position or",
    "t;x;q_axis_current;current_motor": "force, q_axis_current or current_motor?",
    "t;ch1 [deg];ch2 [deg];torque": "position, ch1 or ch2?",
}


@pytest.mark.parametrize("header", AMBIGUOUS)
def test_what_is_ambiguous_ends_in_one_error(header):
    table = read_text("log", written(header), None, None)
    with pytest.raises(RecordingError, match="which column is") as caught:
        assign_roles(table, Description())
    assert AMBIGUOUS[header] in str(caught.value)


def test_a_set_point_alone_is_reported_and_not_taken_for_the_measured_force(read_log):
    reading = read_log(written("t [s];x [rad];input_torque [Nm]"))
    assert reading.recording.force is None
    assert any("'input_torque' is a set point" in str(finding) for finding in reading.findings)


@pytest.mark.parametrize(
    ("names", "unit"),
    [("header.stamp.sec;header.stamp.nanosec", 1e9), ("secs;nsecs", 1e9), ("tv_sec;tv_usec", 1e6)],
)
def test_seconds_and_their_rest_are_one_time(names, unit):
    ticks = 1_700_000_000_400_000_000 + np.arange(900) * 1_000_000
    rows = [f"{t // 10**9};{t % 10**9 * int(unit) // 10**9};{k}" for k, t in enumerate(ticks)]
    table = with_joined_times(
        read_text("log", "\n".join([f"{names};x", *rows]).encode(), None, None)
    )
    name = assign_roles(table, Description())[0]["time"]
    t = table.numbers[name]
    np.testing.assert_allclose(t - t[0], np.arange(900) * 1e-3, atol=1e-9)


@pytest.mark.parametrize(
    ("first", "step", "header"),
    [
        (1_700_000_000_000_000_000, 1_000_000, "%time;field.position0"),
        (1_700_000_000_000_000, 1_000, "timestamp;pos"),
        (1_700_000_000_000, 1, "timestamp;pos"),
        (0, 1, "millis;pos"),
        (0, 1000, "micros;pos"),
        (0, 1_000_000, "time_ns;pos"),
    ],
)
def test_times_are_in_s(first, step, header, read_log):
    rows = [f"{first + k * step};{np.sin(k / 9):.9f}" for k in range(900)]
    t = read_log("\n".join([header, *rows])).recording.t
    np.testing.assert_allclose(t, np.arange(900) * 1e-3, rtol=1e-6)


LBF, OZF, KGF, TURN = 4.4482216152605, 4.4482216152605 / 16, 9.80665, 2 * np.pi
UNITS = {
    "turns/s": ("angular speed", TURN), "r/min": ("angular speed", TURN / 60),
    "deg/min": ("angular speed", TURN / 21600), "krpm": ("angular speed", TURN * 1000 / 60),
    "dps": ("angular speed", TURN / 360), "ticks/s": ("number per time", 1),
    "counts/ms": ("number per time", 1000), "mrev": ("angle", TURN / 1000),
    "oz-in": ("torque", OZF * 0.0254), "in-lb": ("torque", LBF * 0.0254),
    "lbf.ft": ("torque", LBF * 0.3048), "kg*cm": ("torque", KGF / 100), "cNm": ("torque", 0.01),
    "mN·m": ("torque", 1e-3), "N-m": ("torque", 1), "N m": ("torque", 1), "nsecs": ("time", 1e-9),
    "ft/s": ("speed", 0.3048), "µm": ("length", 1e-6), "nm": ("length", 1e-9), "Nm": ("torque", 1),
    "mN": ("force", 1e-3), "RPM": ("angular speed", TURN / 60), "°": ("angle", TURN / 360),
    "MN": None, "foo": None, "": None, "NM": None, "m^2": None, "N/m": None,
}  # fmt: skip


SUFFIXES = {
    "torque_mNm": "mN.m", "current_mA": "mA", "Strom_mA": "mA", "force_kN": "kN",
    "torque_nm": "N.m", "velocity_rpm": "rpm", "vel_rad_per_s": "rad/s", "cmd_rad_s": "rad/s",
    "timeMs": "ms", "vel_mm_s": "mm/s", "speed mm/s": "mm/s", "t_us": "us", "POS_MM": "mm",
    "torque_N_m": "N.m", "vCmd": None, "x_m": None, "pos_min": None,
}  # fmt: skip


@pytest.mark.parametrize("name", SUFFIXES)
def test_units_at_the_end_of_names(name):
    role, *_ = assign_roles(LogTable("log", (name,), {name: np.zeros(3)}), Description())[0] or [""]
    unit = unit_of(LogTable("log", (name,), {}), Description(), role or "position", name)
    assert (unit and unit.name) == SUFFIXES[name]


@pytest.mark.parametrize("name", UNITS)
def test_units_that_tools_write(name):
    unit = unit_named(name)
    found = unit and (unit.quantity, unit.factor)
    assert found == (UNITS[name] and (UNITS[name][0], pytest.approx(UNITS[name][1], rel=1e-15)))
