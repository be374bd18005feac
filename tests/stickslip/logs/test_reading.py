"""What is written in any dialect reads back equal, in SI units, with work in proportion to it."""

import cProfile
import io
from contextlib import suppress

import numpy as np
import pandas as pd
import pytest
import scipy.io

from stickslip.errors import RecordingError, UsageError
from stickslip.logs import Column, Description, Recording, read_recording
from stickslip.logs.text import read_text

BARE = Description(columns={"time": Column(1), "position": Column("2"), "force": Column(3)})


def equals(recording: Recording, table: pd.DataFrame) -> None:
    """Check that a recording holds the columns of a table in SI units."""
    np.testing.assert_allclose(recording.t, table["time"], rtol=1e-12, atol=1e-12)
    for name in table.columns.drop("time"):
        signal = getattr(recording, name)
        if signal is not None:
            np.testing.assert_allclose(signal, table[name], rtol=1e-12, err_msg=name)


@pytest.mark.parametrize(("stated", "limit"), [(None, 5.0), (4.5, 4.5)])
def test_a_limit_that_is_not_stated_is_that_of_the_controller(table, read_log, stated, limit):
    gains = {"K_p": 1.0, "u_max": 5.0}
    given = Description(controller="P", gains=gains, force_limit=stated)
    assert read_log(table.to_csv(index=False), given).force_limit == limit
    assert read_log(table.to_csv(index=False), Description()).force_limit is None


@pytest.mark.parametrize("delimiter", [",", ";", "\t", "|", " "])
@pytest.mark.parametrize("decimal", [".", ","])
@pytest.mark.parametrize("header", [True, False])
def test_text_in_any_dialect(table, read_log, delimiter, decimal, header):
    if delimiter == decimal:
        pytest.skip("no dialect")
    text = table.to_csv(index=False, sep=delimiter, decimal=decimal, header=header)
    reading = read_log(text, None if header else BARE)
    equals(reading.recording, table)
    assert reading.recording.encoder_step == pytest.approx(4e-7, rel=1e-6)
    assert (reading.recording.velocity_command is not None) == header


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
@pytest.mark.parametrize("ending", ["\n", "\r\n", "\r"])
def test_encodings_and_line_ends(table, read_log, encoding, ending):
    renamed = table.rename(columns={"position": "position [µm]"})
    renamed["position [µm]"] *= 1e6
    text = renamed.to_csv(index=False, lineterminator=ending)
    equals(read_log(text.encode(encoding)).recording, table)


def test_a_header_behind_a_comment_sign_and_columns_of_text(table, read_log):
    stream = io.StringIO()
    np.savetxt(stream, table.to_numpy(), header="t x F v_cmd", fmt="%.17g")
    equals(read_log(stream.getvalue(), name="log.dat").recording, table)
    text = table.assign(status="OK, running", note="").to_csv(index=False)
    equals(read_log(text).recording, table)


def test_points_in_time_become_seconds(table, read_log):
    stamps = pd.Timestamp("2026-02-03T10:00:00") + pd.to_timedelta(table["time"], unit="s")
    table_with = table.assign(time=stamps.dt.round("us").astype(str))
    equals(read_log(table_with.to_csv(index=False)).recording, table)


@pytest.mark.parametrize("kind", [np.float64, np.float32, np.int32])
def test_parquet(table, tmp_path, kind):
    if kind is np.int32:
        counts = (table["position"] / 4e-7).round().astype(kind)
        stored = table.assign(position=counts).rename(columns={"position": "position [counts]"})
    else:
        stored = table.astype({"force": kind})
        table = stored.astype(np.float64)
    stored.to_parquet(tmp_path / "log.parquet")
    reading = read_recording(tmp_path / "log.parquet", Description(encoder_step=4e-7))
    equals(reading.recording, table)


@pytest.mark.parametrize("compressed", [False, True])
@pytest.mark.parametrize("shape", ["row", "column", "struct", "matrix"])
def test_mat(table, tmp_path, compressed, shape):
    columns = {name: table[name].to_numpy() for name in table}
    given = None
    if shape == "struct":
        content = {"log": {"run": columns}, "n": 3}
    elif shape == "matrix":
        content = {"data": table.to_numpy()}
        keys = ("time", "position", "force")
        given = Description(columns={k: Column(f"data({i})") for i, k in enumerate(keys, 1)})
    else:
        content = {**columns, "name": "axis", "parts": np.array(["a", 1.0], dtype=object)}
    one_d = "column" if shape == "column" else "row"
    path = tmp_path / "log.mat"
    scipy.io.savemat(path, content, do_compression=compressed, oned_as=one_d)
    equals(read_recording(path, given).recording, table)


def test_scalars_of_a_mat_file_may_be_named(table, tmp_path):
    columns = {name: table[name].to_numpy() for name in table}
    columns["force"] = columns["force"] / 7.0
    path = tmp_path / "log.mat"
    scipy.io.savemat(path, {**columns, "gtau": 3.5, "kp": 160.0, "kv": 240})
    given = Description(
        columns={"force": Column("force", "V", "2*gtau")},
        controller="cascade",
        gains={"K_x": "kp", "K_p": "kv * gtau"},
    )
    reading = read_recording(path, given)
    equals(reading.recording, table)
    assert reading.controller.K_x == 160.0
    assert reading.controller.K_p == 840.0


def test_a_span_an_offset_and_a_given_period(table, read_log):
    given = Description(columns={"force": Column(offset=2.0)}, span=(0.1, 0.3))
    recording = read_log(table.to_csv(index=False), given).recording
    assert len(recording.t) == 201
    assert recording.t[0] == 0
    np.testing.assert_allclose(recording.force, table["force"][100:301] + 2.0)
    coarse = table.assign(time=np.floor(table["time"] * 100) / 100)
    coarse = coarse.to_csv(index=False)
    equals(read_log(coarse, Description(sample_period=1e-3)).recording, table)


R = np.random.default_rng(3)
BLANK, N_A = "\n" * 3, "n/a;n/a"


def row(k: int) -> str:
    return f"{k * 1e-3:.3f},{k % 97 * 1e-4:.5f},{k % 31:d}\n"


def late(begin, n: int) -> str:
    clock = [f"10:{k // 60:02d}:{k % 60:02d}.000;" for k in range(2 * n)]
    rows = [clock[k] + (begin if k < n else f"{k % 7};{k % 5}") for k in range(2 * n)]
    return "time;angle [rad];torque [Nm]\n" + "\n".join(rows)


KINDS = {
    "prose": lambda n: "the drive is running fine\n" * n,
    "prose above a log": lambda n: "the drive runs\n" * n + "t x F\n" + "0.1 2 3\n" * 9,
    "hexadecimal": lambda n: "".join(f"{R.integers(1 << 60):016x} {k:08x}\n" for k in range(n)),
    "keys and values": lambda n: "".join(f"key{k}=value{k}\n" for k in range(n)),
    "rows that say n/a": lambda n: late(N_A, n),
    "rows of text": lambda n: late("waiting;waiting", n),
    "all fields missing": lambda n: "t,x,F\n" + "n/a,n/a,n/a\n" * n + row(1) * n,
    "an unclosed quote": lambda n: 't,x,F\n"' + "a,b\n" * n,
    "quotes": lambda n: '"""",""\n' * n,
    "one line": lambda n: "1,2;3 " * n,
    "blank lines": lambda n: BLANK * n + row(1),
    "comments": lambda n: "# 1 2 3\n" * n,
    "mixed widths": lambda n: "".join("1," * (k % 7) + "1\n" for k in range(n)),
    "repeated headers": lambda n: "t,x,F\n" * n + row(1) * n,
    "many columns": lambda n: ",".join(f"a{k}" for k in range(n)) + "\n" + ("1," * n + "\n") * 3,
    "many pairs": lambda n: "time,x\t" * n + "\n" + ("1,2\t" * n + "\n") * 3,
    "only carriage returns": lambda n: KINDS["a log"](n).replace("\n", "\r"),
    "a log": lambda n: "t,x,F\n" + "".join(map(row, range(n))),
}


def calls(text: str) -> int:
    """Return how many functions, iterations of generators among them, reading a text calls."""
    profile = cProfile.Profile()
    with suppress(RecordingError, UsageError):
        profile.runcall(read_text, "log", text.encode(), None, None)
    return sum(each.callcount for each in profile.getstats())


@pytest.mark.parametrize("kind", KINDS)
def test_twice_the_text_is_at_most_twice_the_work(kind):
    assert calls(KINDS[kind](600)) < 2.2 * calls(KINDS[kind](300))


@pytest.mark.parametrize("begin", [N_A, "waiting;waiting", "-;-", ";"])
def test_a_log_that_begins_late_is_read(begin):
    table = read_text("log", late(begin, 300).encode(), None, None)
    assert table.names == ("time", "angle", "torque")
    assert table.units == {"time": "s", "angle": "rad", "torque": "Nm"}
    assert [len(table.numbers[name]) for name in ("angle", "torque")] == [600, 600]
    assert set(table.faults) == ({"angle", "torque"} if "waiting" in begin else set())


def test_the_delimiter_may_be_the_decimal_sign_in_quotes_only():
    rows = "t,x,F\n" + '"0,5","1,25",3\n' * 9
    table = read_text("log", rows.encode(), ",", ",")
    assert [table.numbers[name][0] for name in table.names] == [0.5, 1.25, 3.0]
    with pytest.raises(UsageError, match=r"^log: delimiter and decimal sign are both ','"):
        read_text("log", rows.replace('"', "").encode(), ",", ",")
