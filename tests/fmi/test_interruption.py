"""A signal ends a program in one way, and closed streams do not lend their numbers to files."""

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from stickslip.fmi.process import (
    Threads,
    check_interruption,
    held,
    interrupted_by,
    interruptible,
    temporary_folder,
)

pytestmark = [pytest.mark.slow, pytest.mark.skipif(sys.platform == "win32", reason="needs SIGTERM")]
ROOT = Path(__file__).parents[2]

NATIVE = """
import ctypes, sys
from stickslip.fmi.process import interruption
interruption.DEADLINE, interruption.AGAIN = float(sys.argv[1]), 0.3
mutex = ctypes.create_string_buffer(64)
library = ctypes.CDLL(None)
with interruption.interruptible(), interruption.temporary_folder():
    library.pthread_mutex_lock(mutex)
    print("ready", flush=True)
    library.pthread_mutex_lock(mutex)  # never returns
"""
BUSY = """
import time
from stickslip.fmi.process import interruptible
with interruptible():
    print("ready", flush=True)
    while True:  # comes to no point that raises by itself
        try:
            time.sleep(60)
        finally:
            print("unwound", flush=True)
"""


def start(program, *arguments, **settings):
    process = subprocess.Popen(
        [sys.executable, "-c", program, *arguments],
        env=os.environ | {"PYTHONPATH": str(ROOT)} | settings,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout.readline() == "ready\n"
    return process


@pytest.mark.parametrize("twice", [False, True])
def test_native_code_that_never_returns_is_ended_and_its_folders_go(tmp_path, twice):
    with start(NATIVE, "60" if twice else "0.5", TMPDIR=str(tmp_path)) as process:
        assert list(tmp_path.iterdir())
        process.terminate()
        if twice:
            with pytest.raises(subprocess.TimeoutExpired):
                process.wait(1.0)
            process.terminate()
        said = process.communicate(timeout=20)[1]
    assert (process.returncode, said) == (143, "stickslip: interrupted; ended at once\n")
    assert not list(tmp_path.iterdir())


def test_python_code_that_looks_for_no_signal_is_unwound():
    with start(BUSY) as process:
        process.send_signal(signal.SIGHUP)
        out, error = process.communicate(timeout=20)
    assert out == "unwound\n"
    assert error.endswith("KeyboardInterrupt\n")


def nested(number, done):
    with held():
        with held():
            signal.raise_signal(number)
        done.append("all")


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_signal_waits_for_the_end_of_a_held_block(name):
    number, done = getattr(signal, name), []
    with interruptible():
        with pytest.raises(KeyboardInterrupt):
            nested(number, done)
        assert interrupted_by() == number
        with pytest.raises(KeyboardInterrupt):
            check_interruption()
    assert done == ["all"]
    assert interrupted_by() is None
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL


def test_what_is_ignored_stays_ignored():
    """As SIGHUP is under nohup."""
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with interruptible():
            signal.raise_signal(signal.SIGHUP)
            check_interruption()
    finally:
        signal.signal(signal.SIGHUP, before)


def test_cleaning_up_is_not_interrupted_again():
    cleaned = []

    def work():
        try:
            signal.raise_signal(signal.SIGTERM)
            check_interruption()
        finally:
            with held():
                signal.raise_signal(signal.SIGTERM)
            check_interruption()
            cleaned.append(True)

    with interruptible(), pytest.raises(KeyboardInterrupt):
        work()
    assert cleaned


def test_threads_end_at_their_next_safe_point():
    began = threading.Event()

    def work(_):
        began.set()
        while True:
            check_interruption()

    def signal_when_begun():
        began.wait()
        os.kill(os.getpid(), signal.SIGTERM)

    threading.Thread(target=signal_when_begun).start()
    with interruptible(), pytest.raises(KeyboardInterrupt), Threads(2) as threads:
        threads.each(work, range(5))


def test_a_temporary_folder_of_any_depth_is_removed():
    before = Path.cwd()
    try:
        with temporary_folder() as folder:
            os.chdir(folder)
            for _ in range(1100):  # Python's own removal calls itself, and ends at 1000
                Path("a").mkdir()
                os.chdir("a")
            Path("file").write_text("")
            (folder / "closed").mkdir(0)
    finally:
        os.chdir(before)
    assert not folder.exists()


SCRIPT = """
import os, sys
sys.path[:0] = {path!r}
from stickslip.fmi.process import open_standard_streams
open_standard_streams()
for number in range(3):
    assert os.get_inheritable(number)
print("printed")
print("printed", file=sys.stderr)
sys.stdout.flush()
assert sys.stdin.read() == ""
assert os.open({out!r}, os.O_CREAT | os.O_WRONLY) > 2
"""


@pytest.mark.parametrize("closed", ["", "0<&-", "1>&-", "2>&-", "0<&- 1>&-", "0<&- 1>&- 2>&-"])
def test_closed_streams_become_the_null_device(tmp_path, closed):
    script, out = tmp_path / "script.py", tmp_path / "out"
    script.write_text(SCRIPT.format(path=sys.path, out=str(out)))
    command = f"{sys.executable} {script} {closed}"
    done = subprocess.run(command, shell=True, input="", capture_output=True, text=True)  # noqa: S602
    assert done.returncode == 0, done.stderr
    assert out.read_bytes() == b""
    assert done.stdout == ("" if "1>" in closed else "printed\n")
    assert done.stderr == ("" if "2>" in closed else "printed\n")
    assert os.fstat(0)
