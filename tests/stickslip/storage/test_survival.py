"""Whoever kills or interrupts a command finds the old set, the new one or nothing."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from stickslip import models

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def outcomes():
    """What was found; a set that is lost makes the process fail."""
    if sys.platform == "win32":
        pytest.skip("forks")
    command = [sys.executable, "-m", "campaigns.survival"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize(
    ("how", "least"), [("killed", 41), ("full once", 36), ("full for good", 36)]
)
def test_before_any_operation_a_whole_set_is_left(outcomes, how, least):
    """Only while the files change places does it take ``stickslip verify`` to see a whole set."""
    assert outcomes[how]["at once"] >= least
    assert outcomes[how]["recovered"] <= 6  # one for each file of the new set, and one that leaves
    assert how != "killed" or outcomes[how]["recovered"] > 0


in_proc = pytest.mark.skipif(not Path("/proc").is_dir(), reason="looks for processes in /proc")


def ended(words, number, folder, at_work, *, group=False):
    """Send a signal to a command at work; return its status and errors. It leaves nothing."""
    temporary, mark = folder / "tmp", f"signals-{os.getpid()}"
    temporary.mkdir()
    there = {"child": lambda: len(_marked(f"MARK={mark}".encode())) > 1}
    ready = there.get(at_work, lambda: any(temporary.rglob(at_work)))
    with subprocess.Popen(
        [sys.executable, "-m", "stickslip", *words],
        env=os.environ | {"TMPDIR": str(temporary), "PYTHONPATH": str(ROOT), "MARK": mark},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        while not ready() and process.poll() is None:
            time.sleep(0.02)
        send = os.killpg if group else os.kill
        send(process.pid, number)
        said = process.communicate(timeout=60)[1]
    assert not list(temporary.iterdir())
    _assert_gone(mark)
    return process.returncode, said


@in_proc
def test_ctrl_c_leaves_no_process_and_no_folder(log, tmp_path):
    """With a pool of processes, in the middle of a fleet; only what is kept of it stays."""
    table = tmp_path / "table.csv"
    table.write_text(f"name,log\na,none.csv\nb,{log}\n")
    pool = ["--workers", "2", "--pool", "processes", "--out", str(tmp_path / "out")]
    words = ["fleet", str(table), *pool]
    status, said = ended(words, signal.SIGINT, tmp_path, "*.fmu", group=True)  # as a terminal does
    assert status == 130, said
    assert "interrupted" in said


COMMANDS = {
    "simulate": (
        ["simulate", "FMU", "--step=1e-7", "--stop=10", "--last", "--isolate", "--allow=env=MARK"],
        "child",
    ),
    "check": (["check", "--allow=env=MARK", "FMU", "FMU", "FMU", "FMU"], "fmucheck-*"),
    "identify": (["identify", "--out", "OUT"], "stickslip-*/drive.fmu"),
}
"""Commands, and what there is in the temporary folder, or as a process, when they are at work."""


@in_proc
@pytest.mark.parametrize(
    ("command", "number"),
    [*((command, signal.SIGTERM) for command in COMMANDS), ("check", signal.SIGHUP)],
)
def test_what_ends_a_process_is_one_line_and_leaves_nothing(command, number, tmp_path):
    arguments, at_work = COMMANDS[command]
    out = tmp_path / "out"
    names = {"OUT": str(out)}
    if "FMU" in arguments:
        names["FMU"] = str(models.build_fmu("compensator", tmp_path))
    words = [names.get(word, word) for word in arguments]
    found = ended(words, number, tmp_path, at_work)
    assert found == (128 + number, "stickslip: interrupted\n")
    assert not out.exists() or not list(out.rglob("*"))


def _assert_gone(mark):
    """Check that no process with a mark is left; one that was killed may take a moment to end."""
    deadline = time.monotonic() + 5.0
    while _marked(f"MARK={mark}".encode()):
        assert time.monotonic() < deadline
        time.sleep(0.01)


def _marked(mark):
    """Return the processes that have something in their environment."""
    found = []
    for path in Path("/proc").glob("[0-9]*/environ"):
        try:
            if mark in path.read_bytes():
                found.append(path.parent.name)
        except OSError:
            continue  # another user's, or gone
    return found
