"""Rows become samples of one even clock, findings tell what was done; sets of logs are joined."""

import numpy as np
import pandas as pd
import pytest

from stickslip.errors import RecordingError, UsageError
from stickslip.logs import Description
from stickslip.logs.grid import even_grid
from stickslip.logs.joined import join
from stickslip.logs.sampling import mean_period, regular_times, step_of
from stickslip.logs.sets import logs_of
from stickslip.logs.table import LogTable
from tests.stickslip.logs.rigid_drive import rigid_drive

K = np.arange(6000)
LOST = np.delete(K, [40, 41, 999, 3000, 3001, 3002, 3003, 5990])
DRIFT = np.arange(40_000) * 2.5e-4 * (1.0 + 1e-5 * np.arange(40_000) * 2.5e-4)


def stepped(T_s, step, rounding=np.round):
    t = 3.7 + K * T_s
    return t, step * rounding(t / step + 1e-9), 0.01 * step


REGULAR = {
    "0.1 ms at 4 kHz": stepped(2.5e-4, 1e-4),
    "0.1 ms at 4 kHz, cut off": stepped(2.5e-4, 1e-4, np.floor),
    "pairs of equal times": stepped(5e-4, 1e-3, np.floor),
    "three rows a time": stepped(1e-3 / 3, 1e-3),
    "1 us at 7 kHz": stepped(1 / 7000, 1e-6),
    "a clock of 32768 Hz": stepped(2.5e-4, 1 / 32768, np.floor),
    "single precision": (60.0 + K / 7000, (60.0 + K / 7000).astype(np.float32).astype(float), 1e-7),
    "single precision from 0": (K / 7000, (K / 7000).astype(np.float32).astype(float), 2e-8),
    "a clock that drifts": (DRIFT, np.round(DRIFT, 4), 4e-5),
    "lost rows": (LOST * 2.5e-4, np.round(LOST * 2.5e-4, 4), 2e-6),
}
"""True times, rounded times, and the error that is left."""


@pytest.mark.parametrize("name", REGULAR)
def test_a_regular_clock_is_recovered_from_its_rounded_times(name):
    t, rounded, tolerance = REGULAR[name]
    found = regular_times(rounded, mean_period(rounded))
    assert np.ptp(found - t) < tolerance


@pytest.mark.parametrize("digits", [4, 6, 12])
@pytest.mark.parametrize("jitter", [0.15, 0.3])
def test_a_clock_that_jitters_is_not_regular(digits, jitter):
    t = np.arange(5000) * 1e-3
    t += np.random.default_rng(1).uniform(-jitter, jitter, 5000) * 1e-3
    t = np.round(t, digits)
    assert regular_times(t, mean_period(t)) is None


@pytest.fixture
def log() -> pd.DataFrame:
    drive = rigid_drive(n=4000, step=4e-7)
    return pd.DataFrame({"t [s]": drive.t, "x [m]": drive.position, "F [N]": drive.force})


@pytest.fixture
def read(read_log):
    def run(table, **given):
        reading = read_log(table.to_csv(index=False), Description(**given))
        return reading.recording, "\n".join(map(str, reading.findings))

    return run


REPEATED = {
    "every 50th row": np.sort(np.r_[np.arange(4000), np.arange(0, 4000, 50)]),
    "every row": np.repeat(np.arange(4000), 2),
    "a block": np.r_[np.arange(2000), np.arange(1700, 4000)],
}


@pytest.mark.parametrize("name", REPEATED)
@pytest.mark.parametrize("given", [{}, {"sample_period": 1e-3}])
def test_copies_of_rows_are_dropped(log, read, name, given):
    if given and name == "every row":
        pytest.skip("half of the sample period contradicts the column of time")
    recording, found = read(log.iloc[REPEATED[name]], **given)
    np.testing.assert_array_equal(recording.position, log["x [m]"])
    assert f"dropped: {len(REPEATED[name]) - 4000}, the first is row" in found


def in_turn(table, shift: int, every: int = 1) -> pd.DataFrame:
    """Return a log whose force has rows of its own, with blanks in the others."""
    position, force = table.iloc[::2].copy(), table.iloc[shift :: 2 * every].copy()
    position["F [N]"] = np.nan
    force["x [m]"] = np.nan
    return pd.concat([position, force]).sort_values("t [s]", kind="stable")


@pytest.mark.parametrize(("shift", "every"), [(0, 1), (1, 1), (1, 3)])
def test_channels_with_times_of_their_own_are_joined(read, shift, every):
    drive = rigid_drive(n=8000, T_s=5e-4, F_c=0.0)
    log = pd.DataFrame({"t [s]": drive.t, "x [m]": drive.position, "F [N]": drive.force})
    recording, found = read(in_turn(log, shift, every))
    assert recording.T_s == pytest.approx(1e-3)
    assert ("joined" if shift == 0 else "interpolated to those of the position: force") in found
    k = np.argmin(np.abs(drive.position - recording.position[500]))
    first = round(k / 2) - 500
    expected = drive.force[::2][first : first + len(recording.t)]
    assert np.max(np.abs(recording.force - expected)) < 0.02 * np.max(np.abs(expected))


def test_a_channel_that_is_far_slower_and_a_period_that_hides_channels_are_errors(log, read):
    slow = log.assign(**{"F [N]": log["F [N]"].where(log.index % 20 == 0)})
    with pytest.raises(RecordingError, match=r"force was sampled each 0[.]02 s, and the position"):
        read(slow)
    # half of the rows hold no position: a period for each row would be wrong
    with pytest.raises(RecordingError, match="without sample_period"):
        read(in_turn(log, 1), sample_period=1e-3)


TABLE = LogTable("log", (), {})
DRIVE = rigid_drive(n=3000)
T_S = DRIVE.T_s


def messages(done) -> str:
    return "\n".join(map(str, done))


def test_even_times_are_left_alone():
    t_even, found, done = even_grid(TABLE, DRIVE.t + 7.5, {"position": DRIVE.position})
    assert np.array_equal(found["position"], DRIVE.position)
    assert not done
    np.testing.assert_allclose(t_even, DRIVE.t, atol=1e-12)


@pytest.mark.parametrize("share", [0.05, 0.3])
def test_jitter_is_taken_out(share):
    """A smooth signal is drawn by a cubic: its error falls far below that of the jitter."""
    rng = np.random.default_rng(0)
    t = DRIVE.t + rng.uniform(-share, share, len(DRIVE.t)) * T_S
    x = np.interp(t, DRIVE.t, DRIVE.t)  # the true times, to evaluate the drive at
    x = 0.02 * np.sin(2 * np.pi * (0.4 * x + 0.25 * x**2))
    t_even, found, done = even_grid(TABLE, t, {"position": x})
    assert "times are uneven" in messages(done)
    assert "cubic" in messages(done)
    expected = t_even + t[0]
    expected = 0.02 * np.sin(2 * np.pi * (0.4 * expected + 0.25 * expected**2))
    assert np.max(np.abs(found["position"] - expected)) < 2e-9
    assert np.ptp(np.diff(t_even)) < 1e-12


def test_a_command_with_corners_is_drawn_by_lines():
    rng = np.random.default_rng(1)
    t = np.sort(DRIVE.t + rng.uniform(-0.3, 0.3, len(DRIVE.t)) * T_S)
    corners = np.sign(np.sin(40 * t))
    _, found, done = even_grid(TABLE, t, {"velocity_command": corners})
    assert "velocity_command linear" in messages(done)
    assert np.abs(found["velocity_command"]).max() <= 1.0


@pytest.mark.parametrize("n", [1, 5, 6, 100])
def test_short_gaps_are_filled_and_long_ones_cut(n):
    """Rows or numbers: five missing samples in a row are filled in, six split the log."""
    missing = np.arange(1000, 1000 + n)
    rows = np.delete(np.arange(3000), missing)
    force = DRIVE.force.copy()
    force[missing] = np.nan
    used = slice(None) if n <= 5 else slice(1000 + n, None)
    whole = {"position": DRIVE.position, "force": force}
    for t, signals in ((DRIVE.t[rows], {"position": DRIVE.position[rows]}), (DRIVE.t, whole)):
        _, found, done = even_grid(TABLE, t, signals)
        expected = DRIVE.position[used]
        np.testing.assert_allclose(found["position"], expected, rtol=0, atol=1e-9)
        said = f"{n} rows missing" if n <= 5 else f"rows 1001 to {3000 - n}"
        if t is DRIVE.t:
            said = f"{n}, the first in row 1001" if n <= 5 else f"in rows 1001 to {1000 + n}"
            assert np.isfinite(found["force"]).all()
        assert said in messages(done)


def test_the_step_of_an_encoder_is_found_and_other_signals_have_none():
    for step, offset in ((4e-7, 0.0), (5e-8, 0.1234), (1e-3, 0.0), (1e-3, 0.1234)):
        x = np.round(DRIVE.position / step) * step + offset
        assert step_of(x) == pytest.approx(step, rel=1e-6)
    assert step_of(DRIVE.position) == 0
    assert step_of(np.random.default_rng(0).standard_normal(5000)) == 0
    assert step_of(np.zeros(100)) == 0
    even = np.round(0.2985 * np.arange(400.0), 3)  # of the motion, not of the encoder
    assert step_of(even) == 0
    assert step_of(0.01 * np.round(even * np.sin(even))) == pytest.approx(0.01)


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
        (None, r"no log in this folder; expected files of .*\.csv"),
        ("log,mass\na.csv,1\n", "row 1: expected log, config, .* got 'mass'"),
        ("log,load\nc.csv,1\n", "row 2: log 'c.csv': no such file"),
        ("log,load\na.csv,1 kg\n", "row 2: load '1 kg': expected a mass"),
        ("log,gains\na.csv,K=1\n", "row 2: gains 'K=1': expected NAME=VALUE"),
        ("log,use\na.csv,test\n", "row 2: use 'test': expected learn or validate"),
        ("log,load\na.csv\n", "row 2: expected 2 cells, got 1"),
        ("log\n", "without a row"),
    ],
)
def test_a_table_that_does_not_suit_or_a_folder_without_logs_is_one_line(tmp_path, table, line):
    with pytest.raises(UsageError, match=line) as caught:
        logs_of([written(tmp_path, table) if table else tmp_path], SOME)
    assert "\n" not in str(caught.value)


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
