"""Logs of drives and their tools (vendor_texts.py) are read without options."""

import numpy as np
import pytest
from vendor_texts import FILES, F, N, T, V, X, rows, titled

from stickslip.errors import RecordingError, UsageError
from stickslip.logs import Column, Description, read_recording
from stickslip.logs.header import split_unit
from stickslip.logs.roles import assign_roles
from stickslip.logs.table import LogTable


@pytest.mark.parametrize("name", FILES)
def test_a_vendor_file_needs_no_option(name, tmp_path):
    path = tmp_path / "log.csv"
    path.write_bytes(FILES[name].encode("latin-1"))
    reading = read_recording(path)
    recording = reading.recording
    np.testing.assert_allclose(recording.t, T, atol=1e-9)
    np.testing.assert_allclose(recording.position, X, atol=1e-10)
    np.testing.assert_allclose(recording.force, F, rtol=1e-8)
    if "Soll" in FILES[name] or "SetPos" in FILES[name]:
        np.testing.assert_allclose(recording.position_command, X + 1e-3, atol=1e-10)
    assert not {"position", "force", "time"} & set(reading.assumed)


TORQUE = np.sin(9 * T) * 0.7


def test_channels_of_twincat_with_other_periods(tmp_path):
    """Each channel has its own times; the force every 2 ms comes on those of the position."""
    pair = "{:.9g}\t{:.9g}\t".format
    head = titled("Name", "Axis 1.ActPos", "Axis 1.ActForce")
    head += titled("SampleTime[ms]", "1", "2") + titled("Unit", "mm", "N")
    lines = [
        pair(T[k] * 1e3, X[k] * 1e3) + (pair(T[2 * k] * 1e3, F[2 * k]) if 2 * k < N else "\t\t")
        for k in range(N)
    ]
    path = tmp_path / "log.csv"
    path.write_text("Name\tScope\n\n" + head + "\n" + "\n".join(lines) + "\n")
    recording = read_recording(path).recording
    np.testing.assert_allclose(recording.position, X[:-1], atol=1e-10)
    np.testing.assert_allclose(recording.force[::2], F[:-1:2], rtol=1e-7)


RATED = {
    "percent": ("Drehmomentistwert [%]", TORQUE / 2.4 * 100, {"rated_torque": 2.4}),
    "per mille": ("Torque actual value [0.1%]", TORQUE / 2.4 * 1000, {"rated_torque": 2.4}),
    "object": ("0x6077", TORQUE / 2.4 * 1000, {"rated_torque": 2.4}),
    "current": ("Iq [%]", TORQUE / 2.4 * 100, {"rated_torque": "2*1.2"}),
}


@pytest.mark.parametrize("name", RATED)
def test_a_share_of_a_rated_torque(name, tmp_path):
    header, torque, given = RATED[name]
    path = tmp_path / "log.csv"
    path.write_text(f"Zeit [ms];phi [deg];{header}\n" + rows(T * 1e3, np.rad2deg(X * 9), torque))
    columns = {"force": Column(unit="‰")} if name == "object" else {}
    recording = read_recording(path, Description(columns=columns, **given)).recording
    np.testing.assert_allclose(recording.force, TORQUE, rtol=1e-7)


@pytest.mark.parametrize(
    ("header", "given", "message"),
    [
        ("x [mm];Iq [%]", {}, "of a rated force that is not known; give rated_force=VALUE"),
        (
            "phi [deg];Moment [%]",
            {},
            'give rated_torque=VALUE or columns={"force": Column(scale=VALUE)}, 100 % in N.m',
        ),
        ("x [mm];Moment [%]", {"rated_torque": 2.4}, "the motion is linear; give rated_force"),
        ("phi [deg];Moment [%]", {"rated_force": 2.4}, "give rated_torque, or another motion"),
        ("x [mm];Kraft", {"rated_force": 9.0}, "a rated force is given, but no unit; give columns"),
    ],
)
def test_a_share_of_what_is_not_known(header, given, message, tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(f"Zeit [ms];{header}\n" + rows(T * 1e3, X * 1e3, TORQUE))
    with pytest.raises((RecordingError, UsageError)) as caught:
        read_recording(path, Description(**given))
    assert message in str(caught.value)


def test_increments_of_an_encoder(tmp_path):
    step = 1e-7
    counts = np.round(X / step)
    path = tmp_path / "log.csv"
    header = "Zeit [ms];Lageistwert [inc];Geschwindigkeit [inc/s];Kraft [N]\n"
    path.write_text(header + rows(T * 1e3, counts, V / step, F))
    recording = read_recording(path, Description(encoder_step=step)).recording
    np.testing.assert_allclose(recording.position, counts * step, rtol=1e-6)
    np.testing.assert_allclose(recording.velocity, V, rtol=1e-7)


def test_a_velocity_is_enough(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("Zeit [ms];Drehzahl [1/min];Drehmomentistwert [Nm]\n" + rows(T * 1e3, V, F))
    reading = read_recording(path)
    assert reading.recording.position is None
    np.testing.assert_allclose(reading.recording.velocity, V * np.pi / 30, rtol=1e-7)
    assert any("integrated from the velocity" in str(finding) for finding in reading.findings)
    held = {"controller": "cascade", "gains": {"K_x": 5.0, "K_p": 1.0}}
    with pytest.raises(RecordingError, match="only the velocity was logged"):
        read_recording(path, Description(**held))


NAMES = {
    "Istlage": "position", "Lageistwert": "position", "Soll-Lage": "position_command",
    "Istposition": "position", "s_act": "position", "Istwert [mm]": "position",
    "Sollwert [1/min]": "velocity_command", "n_ist": "velocity", "Drehzahlsollwert":
    "velocity_command", "Axis 1.SetVelo": "velocity_command", "606Ch": "velocity",
    "r0063[0]": "velocity", "r2556": "position_command", "Momentenistwert": "force",
    "Stromistwert momentenbildend": "force", "M_soll": "force_command", "Istkraft": "force",
    "Drive.r80: CO: Torque actual value": "force", "Torque feedforward [Nm]": "added_force",
    "0x60B2": "added_force", "dither force": "added_force", "F_added": "added_force",
    "v_dither": "added_velocity", "pulse force [N]": "added_force",
    "Schleppabstand [mm]": None, "Regelabweichung": None, "Lastmoment": None, "PosDiff": None,
    "velocity feedforward": None, "Lageregler": None, "a_act [m/s^2]": None,
    "t": "time", "Time [s]": "time", "qm": "position", "Actual Position": "position",
    "ActualVelocity": "velocity", "qg": "position_command", "Target position": "position_command",
    "v_cmd": "velocity_command", "torque_setpoint": "force_command", "F_m": "force",
    "drive.F_m": "force", "motor current": "force", "Friction": "friction", "position error": None,
    "Normal": None, "temperature": None, "F_limit": None, "ref [mm/s]": "velocity_command",
    "Setpoint [rpm]": "velocity_command", "command [Nm]": "force_command",
    "angle [deg]": "position", "x [N]": None, "speed [m/s]": "velocity",
}  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_names_of_drives(name):
    short, unit = split_unit(name)
    table = LogTable("log", (short,), {short: np.zeros(3)}, units={short: unit} if unit else {})
    assert assign_roles(table, Description())[0] == ({NAMES[name]: short} if NAMES[name] else {})


def test_a_torque_goes_before_a_current_and_equal_columns_are_one(tmp_path):
    header = "Zeit [ms];phi [deg];Iq [A];Moment [Nm];Zeit 2 [ms]\n"
    path = tmp_path / "log.csv"
    path.write_text(header + rows(T * 1e3, X, F, TORQUE, T * 1e3))
    np.testing.assert_allclose(read_recording(path).recording.force, TORQUE, rtol=1e-7)
