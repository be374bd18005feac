"""Sets of logs: files, folders and tables, joined as one recording."""

import numpy as np
import pytest

from stickslip.errors import RecordingError, UsageError
from stickslip.logs import Description
from stickslip.logs.joined import join
from stickslip.logs.sets import logs_of
from tests.stickslip.logs.rigid_drive import rigid_drive

SOME = Description(controller="PI", gains={"K_p": 1.0, "K_i": 2.0})


def written(folder, table):
    for name in ("a.csv", "b.csv"):
        (folder / name).write_text("time,position\n0,0\n")
    (folder / "own.toml").write_text('motion = "rotary"\n')
    path = folder / "runs.csv"
    path.write_text(table)
    return path


def test_a_table_says_what_differs_from_log_to_log(tmp_path):
    table = "log,load,gains,config,use\na.csv,2.5,K_p=3,,\nb.csv,,,own.toml,validate\n"
    path = written(tmp_path, table)
    first, second = logs_of([path], SOME)
    assert (first.path.name, first.load, first.validates) == ("a.csv", 2.5, False)
    assert first.description.gains == {"K_p": 3.0, "K_i": 2.0}
    assert (second.path.name, second.load, second.validates) == ("b.csv", 0.0, True)
    assert second.description.motion == "rotary"
    assert logs_of([tmp_path], SOME) == [first, second]  # the folder's own table
    path.unlink()
    assert [log.path.name for log in logs_of([tmp_path], SOME)] == ["a.csv", "b.csv"]


@pytest.mark.parametrize(
    ("table", "line"),
    [
        ("log,mass\na.csv,1\n", "row 1: expected log, config, .* got 'mass'"),
        ("log,load\nc.csv,1\n", "row 2: log 'c.csv': no such file"),
        ("log,load\na.csv,1 kg\n", "row 2: load '1 kg': expected a mass"),
        ("log,gains\na.csv,K=1\n", "row 2: gains 'K=1': expected NAME=VALUE"),
        ("log,use\na.csv,test\n", "row 2: use 'test': expected learn or validate"),
        ("log,load\na.csv\n", "row 2: expected 2 cells, got 1"),
        ("log\n", "without a row"),
    ],
)
def test_a_table_that_does_not_suit_is_one_line(tmp_path, table, line):
    with pytest.raises(UsageError, match=line) as caught:
        logs_of([written(tmp_path, table)], SOME)
    assert "\n" not in str(caught.value)


def test_a_folder_without_logs_is_an_error(tmp_path):
    with pytest.raises(UsageError, match=r"no log in this folder; expected files of .*\.csv"):
        logs_of([tmp_path], SOME)


def test_each_log_is_found_again_in_what_joins_them():
    one, other = rigid_drive(), rigid_drive(n=3000, m=5.0)
    whole = join([one, other], [{"K_p": 1.0}, None], [0.0, 2.0])
    assert [(s.gains, s.load) for s in whole.segments] == [({"K_p": 1.0}, 0.0), (None, 2.0)]
    for log, segment in zip((one, other), whole.segments, strict=True):
        again = whole.log(segment)
        for name, signal in log.arrays.items():
            assert np.array_equal(getattr(again, name), signal), name
    speed = np.abs(np.diff(whole.position)).max() / whole.T_s
    assert speed <= np.abs(one.velocity).max() * 1.01  # no jump from log to log


def test_logs_of_other_rates_are_joined_at_the_lowest():
    slow, fast = rigid_drive(n=2000, T_s=2e-3), rigid_drive(n=8000, T_s=5e-4)
    whole = join([fast, slow], [None, None], [0.0, 0.0])
    assert whole.T_s == pytest.approx(2e-3)
    found = whole.log(whole.segments[0])
    assert found.position == pytest.approx(fast.position[::4], abs=1e-9)


def test_logs_that_are_not_of_one_kind_are_refused():
    one, other = rigid_drive(), rigid_drive()
    for name, value, line in (
        ("motion", "rotary", "a log of rotary motion, but"),
        ("force", None, "no force, but"),
    ):
        changed = type(other)(**{**vars(other), name: value})
        with pytest.raises(RecordingError, match=line):
            join([one, changed], [None, None], [0.0, 0.0])
