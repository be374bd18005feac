"""Logs as drives and their tools write them, after the layouts of these tools."""

import numpy as np

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
    "own times": "Zeit 1 [ms];Lageistwert [µm];Zeit 2 [ms];Kraftistwert [N]\n"
    + rows(T * 1e3, X * 1e6, T * 1e3 + 0.0, F),
}  # fmt: skip
