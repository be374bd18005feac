"""CSV files of inputs: what is lawful is read, what is not is told by line and column."""

from __future__ import annotations

import numpy as np
import pytest

from stickslip import cosim


def read(tmp_path, data: bytes):
    file = tmp_path / "in.csv"
    file.write_bytes(data)
    return cosim.Table.all_from_csv(file)


@pytest.mark.parametrize(
    "data",
    [
        b"time,u\n0,1\n1,3\n",
        b"\xef\xbb\xbftime,u\r\n0,1\r\n1,3\r\n",
        b'"time" , "u"\n0,1\n\n1,3'.replace(b'" , "', b'","'),
        b"time, u\r 0 , 1.0\r1e0,+3\r",
        b"u,time\n1,0\n3,1\n",
    ],
    ids=["plain", "mark and CRLF", "quoted", "CR and blanks", "time last"],
)
def test_one_table_in_many_forms(tmp_path, data):
    tables = read(tmp_path, data)
    assert list(tables) == ["u"]
    assert tables["u"].time.tolist() == [0.0, 1.0]
    assert tables["u"].values.tolist() == [1.0, 3.0]


def test_times_may_repeat_and_need_not_cover_the_run(tmp_path):
    table = read(tmp_path, b"time,u\n1,1\n2,2\n2,5\n3,6\n")["u"]
    t = np.array([0.0, 1.5, 2.0, 2.5, 3.0, 9.0])
    assert table.sample(t).tolist() == [1.0, 1.5, 5.0, 5.5, 6.0, 6.0]


def test_one_row_is_a_constant(tmp_path):
    table = read(tmp_path, b"time,u\n5,7\n")["u"]
    assert table.sample(np.array([0.0, 5.0, 9.0])).tolist() == [7.0, 7.0, 7.0]


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"time,u\n0,0\n\n1,x\n", r"line 4: column 'u': expected a finite number, got 'x'"),
        (b"time,u\n2,0\n1,0\n", r"line 3: time falls from 2.0 to 1.0 s"),
        (b"time,u\n0,1_0\n", r"got '1_0'"),
        (b"time,u\n0," + b"9" * 2_000_000, r"line 2: 2000002 characters"),
        (b"", "expected a first line"),
        (b"t,v\n0,1\n", "'time' among them"),
        (b"time,v,v\n0,1,1\n", "distinct"),
        (b"time;v\n0;1\n", "separated by commas"),
        (b"time,v\n", "no values"),
        (b"time,v\n0,1\n1\n", "line 3: expected 2 cells, got 1"),
        (b"time,v\n0,nan\n", "line 2: column 'v': expected a finite number, got 'nan'"),
        (b"time,\x1b[31m\n0,x\n", r"column '\\x1b\[31m'"),
    ],
)
def test_faults_have_a_place(tmp_path, data, message):
    with pytest.raises(cosim.SignalError, match=message) as error:
        read(tmp_path, data)
    assert str(tmp_path / "in.csv") in str(error.value)
    assert "\n" not in str(error.value)
    assert "\x1b" not in str(error.value)


def test_the_input_in_a_package_is_read_alike(tmp_path, make):
    import zipfile

    from stickslip.simulation import MEMBER, packed_input

    system = cosim.System("s")
    system.add("a", make("gain"))
    package = cosim.write_ssp(system, tmp_path / "a.ssp")
    with zipfile.ZipFile(package, "a") as archive:
        archive.writestr(MEMBER, "time,u\n0,0\n1,off\n")
    with pytest.raises(cosim.SignalError, match=r"input\.csv, line 3: column 'u'"):
        packed_input(package)
