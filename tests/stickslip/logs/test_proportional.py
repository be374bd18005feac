"""Text of any kind is read or rejected with work in proportion to its length."""

import cProfile
from contextlib import suppress

import numpy as np
import pytest

from stickslip.errors import RecordingError, UsageError
from stickslip.logs.text import read_text

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
    "only carriage returns": lambda n: ("t,x,F\n" + "".join(map(row, range(n)))).replace(
        "\n", "\r"
    ),
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
