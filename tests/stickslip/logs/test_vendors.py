"""Logs as drives and their tools write them, after their layouts, are read without options."""

import re

import numpy as np
import pytest

from stickslip.errors import RecordingError, UsageError
from stickslip.logs import Column, Description
from stickslip.logs.header import split_unit
from stickslip.logs.roles import assign_roles
from stickslip.logs.table import LogTable

N = 400
T = np.arange(N) * 1e-3
X = 0.02 * np.sin(20 * T)
V = 0.4 * np.cos(20 * T)
F = 30 * np.sin(31 * T)


def german(value) -> str:
    return f"{value:.9g}".replace(".", ",")


def rows(*columns, separator=";", number=german):
    return "".join(
        separator.join(field if isinstance(field, str) else number(field) for field in row) + "\r\n"
        for row in zip(*columns, strict=True)
    )


def titled(title, *values, pairs=True, separator="\t"):
    fields = [f for v in values for f in (title, v)] if pairs else [title, *values]
    return separator.join(fields) + "\r\n"


def twincat(*, pairs: bool, separator: str, number, time=1e3) -> str:
    """TwinCAT Scope: each row of the header has a title, in front of each channel or once."""
    names = ["Axis 1.ActPos", "Axis 1.SetPos", "MAIN.fbAxis.ActTorque"]
    head = [
        separator.join(["Name", "YT Scope Project"]) + "\r\n",
        separator.join(["File", r"C:\TwinCAT\axis 1.svdx"]) + "\r\n",
        separator.join(["Starttime of export", "132424123456780000", "08.09.2020"]) + "\r\n",
        "\r\n",
    ]
    for title, *values in (
        ("Name", *names),
        ("SymbolComment", "", "", "actual torque"),
        ("Data-Type", "REAL64", "REAL64", "REAL64"),
        ("SampleTime[ms]", "1", "1", "1"),
        ("VariableSize", "8", "8", "8"),
        ("SymbolBased", "True", "True", "False"),
        ("IndexGroup", "16448", "16448", "16448"),
        ("NetID", "5.18.1.2.1.1", "5.18.1.2.1.1", "5.18.1.2.1.1"),
        ("Port", "501", "501", "851"),
        ("ScaleFactor", "1", "1", "1"),
        ("BitMask", "0xFFFFFFFF", "0xFFFFFFFF", "0xFFFFFFFF"),
        ("Unit", "mm", "mm", "N"),
    ):
        head.append(titled(title, *values, pairs=pairs, separator=separator))
    t = [str(132424123456780000 + 10000 * k) for k in range(N)] if time is None else T * time
    columns = (X * 1e3, X * 1e3 + 1.0, F)
    data = [c for column in columns for c in (t, column)] if pairs else [t, *columns]
    return "".join(head) + "\r\n" + rows(*data, separator=separator, number=number)


STARTDRIVE = (
    '"Drive_1 trace"\r\n"Cycle";"1,000 ms"\r\n\r\n'
    '"Zeit";"Drive_1.r2521[0]";"Drive_1.r2556";"Drive_1.r80[0]";"Drive_1.r79[0]"\r\n'
    '"";"LR Lageistwert";"LR Lagesollwert";"CO: Drehmomentistwert";"CO: Drehmomentsollwert"\r\n'
    '"ms";"mm";"mm";"N";"N"\r\n'
)
TIA = (
    '"Trace";"Achse_1_Trace"\r\n"Gerät";"PLC_1 [CPU 1515T-2 PN]"\r\n'
    '"Zeitstempel";"12.03.2024 10:21:33,512"\r\n"Abtastung";"MC-Servo [OB91]";"1"\r\n\r\n'
    '"Index";"Zeit [ms]";"""Achse_1"".ActualPosition [mm]";"""Achse_1"".Sollposition [mm]";'
    '"PLC_1.Achse_1.StatusDrive.Istkraft [N]"\r\n'
)
INDEX = [str(k) for k in range(N)]
FILES = {
    "twincat pairs": twincat(pairs=True, separator="\t", number="{:.9g}".format),
    "twincat in German": twincat(pairs=True, separator=";", number=german),
    "twincat with one time": twincat(pairs=False, separator=";", number=german),
    "twincat in s": twincat(pairs=True, separator="\t", number="{:.9g}".format, time=1.0),
    "twincat file time": twincat(pairs=True, separator=";", number=german, time=None),
    "startdrive": STARTDRIVE + rows(T * 1e3, X * 1e3, X * 1e3 + 1, F, F),
    "tia": TIA + rows(INDEX, T * 1e3, X * 1e3, X * 1e3 + 1, F),
    "starter": "time [ms]\tv_set [mm/s]\ts_act [mm]\tF_act [N]\n"
    + rows(T * 1e3, V * 1e3, X * 1e3, F, separator="\t", number="{:.9g}".format),
    "units in brackets": "Zeit;Istposition;Sollposition;Motorkraft\n[s];[mm];[mm];[N]\n"
    + rows(T, X * 1e3, X * 1e3 + 1, F),
    "clock": "Zeit;Position (mm);Kraft (kN);Schleppabstand (mm)\n"
    + rows([f"12.03.2024 10:21:{k // 1000:02d},{k % 1000:03d}" for k in range(N)],
           X * 1e3, F / 1e3, X * 0),
    "time of day": "Timestamp;Lage / mm;Istkraft / N\n"
    + rows([f"23:59:59,{k + 700}" if k < 300 else f"00:00:00,{k - 300:03d}" for k in range(N)],
           X * 1e3, F),
    "numbers in the preamble": "Messung;Achse;3\nKanal;1;2\nZeit;Lage;Kraft\ns;mm;N\n"
    + rows(T, X * 1e3, F),
    "grouped digits": "Zeit [s];Lage [nm];Kraft [N]\n"
    + rows(T, X * 1e9, F, number=lambda a: f"{a:,.12f}".translate(str.maketrans(",.", ".,"))),
    "date and time of day": "Datum;Uhrzeit;Lage [mm];Kraft [N]\n"
    + rows(["12.03.2024"] * N, [f"10:00:00,{k:03d}" for k in range(N)], X * 1e3, F),
    "units behind commas": "time, ms\tdrive.x_enc, mm\tdrive.F_m, N\n"
    + rows(T * 1e3, X * 1e3, F, separator="\t", number="{:.9g}".format),
    "own times": "Zeit 1 [ms];Lageistwert [µm];Zeit 2 [ms];Kraftistwert [N]\n"
    + rows(T * 1e3, X * 1e6, T * 1e3 + 0.0, F),
}  # fmt: skip


@pytest.mark.parametrize("name", FILES)
def test_a_vendor_file_needs_no_option(name, read_log):
    reading = read_log(FILES[name].encode("latin-1"))
    recording = reading.recording
    np.testing.assert_allclose(recording.t, T, atol=1e-9)
    np.testing.assert_allclose(recording.position, X, atol=1e-10)
    np.testing.assert_allclose(recording.force, F, rtol=1e-8)
    if "Soll" in FILES[name] or "SetPos" in FILES[name]:
        np.testing.assert_allclose(recording.position_command, X + 1e-3, atol=1e-10)
    assert not {"position", "force", "time"} & set(reading.assumed)


TORQUE = np.sin(9 * T) * 0.7


def test_channels_of_twincat_with_other_periods(read_log):
    """Each channel has its own times; the force every 2 ms comes on those of the position."""
    pair = "{:.9g}\t{:.9g}\t".format
    head = titled("Name", "Axis 1.ActPos", "Axis 1.ActForce")
    head += titled("SampleTime[ms]", "1", "2") + titled("Unit", "mm", "N")
    lines = [
        pair(T[k] * 1e3, X[k] * 1e3) + (pair(T[2 * k] * 1e3, F[2 * k]) if 2 * k < N else "\t\t")
        for k in range(N)
    ]
    text = "Name\tScope\n\n" + head + "\n" + "\n".join(lines) + "\n"
    recording = read_log(text).recording
    np.testing.assert_allclose(recording.position, X[:-1], atol=1e-10)
    np.testing.assert_allclose(recording.force[::2], F[:-1:2], rtol=1e-7)


RATED = {
    "percent": ("Drehmomentistwert [%]", TORQUE / 2.4 * 100, {"rated_torque": 2.4}),
    "per mille": ("Torque actual value [0.1%]", TORQUE / 2.4 * 1000, {"rated_torque": 2.4}),
    "object": ("0x6077", TORQUE / 2.4 * 1000, {"rated_torque": 2.4}),
    "current": ("Iq [%]", TORQUE / 2.4 * 100, {"rated_torque": "2*1.2"}),
}


@pytest.mark.parametrize("name", RATED)
def test_a_share_of_a_rated_torque(name, read_log):
    header, torque, given = RATED[name]
    text = f"Zeit [ms];phi [deg];{header}\n" + rows(T * 1e3, np.rad2deg(X * 9), torque)
    columns = {"force": Column(unit="‰")} if name == "object" else {}
    recording = read_log(text, Description(columns=columns, **given)).recording
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
def test_a_share_of_what_is_not_known(header, given, message, read_log):
    text = f"Zeit [ms];{header}\n" + rows(T * 1e3, X * 1e3, TORQUE)
    with pytest.raises((RecordingError, UsageError), match=re.escape(message)):
        read_log(text, Description(**given))


def test_increments_of_an_encoder(read_log):
    step = 1e-7
    counts = np.round(X / step)
    header = "Zeit [ms];Lageistwert [inc];Geschwindigkeit [inc/s];Kraft [N]\n"
    text = header + rows(T * 1e3, counts, V / step, F)
    recording = read_log(text, Description(encoder_step=step)).recording
    np.testing.assert_allclose(recording.position, counts * step, rtol=1e-6)
    np.testing.assert_allclose(recording.velocity, V, rtol=1e-7)


def test_a_velocity_is_enough(read_log):
    text = "Zeit [ms];Drehzahl [1/min];Drehmomentistwert [Nm]\n" + rows(T * 1e3, V, F)
    reading = read_log(text)
    assert reading.recording.position is None
    np.testing.assert_allclose(reading.recording.velocity, V * np.pi / 30, rtol=1e-7)
    assert any("integrated from the velocity" in str(finding) for finding in reading.findings)
    held = {"controller": "cascade", "gains": {"K_x": 5.0, "K_p": 1.0}}
    with pytest.raises(RecordingError, match="only the velocity was logged"):
        read_log(text, Description(**held))


NAMES = {
    "Lageistwert": "position", "Soll-Lage": "position_command", "s_act": "position",
    "Istwert [mm]": "position", "Sollwert [1/min]": "velocity_command", "n_ist": "velocity",
    "Drehzahlsollwert": "velocity_command", "Axis 1.SetVelo": "velocity_command",
    "606Ch": "velocity", "r0063[0]": "velocity", "r2556": "position_command",
    "Stromistwert momentenbildend": "force", "M_soll": "force_command", "0x60B2": "added_force",
    "Drive.r80: CO: Torque actual value": "force", "Torque feedforward [Nm]": "added_force",
    "dither force": "added_force", "v_dither": "added_velocity", "Schleppabstand [mm]": None,
    "Regelabweichung": None, "Lastmoment": None, "PosDiff": None, "velocity feedforward": None,
    "Lageregler": None, "a_act [m/s^2]": None, "Time [s]": "time", "qm": "position",
    "ActualVelocity": "velocity", "qg": "position_command", "v_cmd": "velocity_command",
    "drive.F_m": "force", "motor current": "force", "Friction": "friction", "F_limit": None,
    "position error": None, "Normal": None, "temperature": None, "ref [mm/s]": "velocity_command",
    "command [Nm]": "force_command", "angle [deg]": "position", "x [N]": None,
}  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_names_of_drives(name):
    short, unit = split_unit(name)
    table = LogTable("log", (short,), {short: np.zeros(3)}, units={short: unit} if unit else {})
    assert assign_roles(table, Description())[0] == ({NAMES[name]: short} if NAMES[name] else {})


def test_a_torque_goes_before_a_current_and_equal_columns_are_one(read_log):
    header = "Zeit [ms];phi [deg];Iq [A];Moment [Nm];Zeit 2 [ms]\n"
    reading = read_log(header + rows(T * 1e3, X, F, TORQUE, T * 1e3))
    np.testing.assert_allclose(reading.recording.force, TORQUE, rtol=1e-7)
