"""No signal, whenever it comes, leaves a lock of a pool of runs taken.

As a program, ``python test_interrupted.py HOW N``, this sends a signal at every N-th step that
Python takes in a pool of runs, and prints how many steps there are; it hangs if one breaks it.
"""

import signal
import subprocess
import sys
import time
from contextlib import nullcontext, suppress
from pathlib import Path
from types import SimpleNamespace

import pytest

from stickslip.fmi.process import interruptible
from stickslip.identification.criteria.runs import Runs
from tests.kept import further

ROOT = Path(__file__).parents[3]
STRIDE = 7
IDLE = SimpleNamespace(run=lambda *_, **__: time.sleep(1e-3), close=lambda: None)
"""Stands for a simulation."""


def run(at, number):
    """Send a signal at the n-th event of tracing in this thread; return whether there is one."""
    count = 0

    def interrupt(*_):
        nonlocal count
        count += 1
        if count == at:
            signal.raise_signal(number)
        return interrupt

    sys.settrace(interrupt)
    try:
        with Runs(SimpleNamespace(prepare=lambda: IDLE), 2) as runs:
            runs.each(lambda _: runs.run({}, {}), range(3))
    finally:
        sys.settrace(None)
    return count >= at


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs SIGTERM")
@pytest.mark.parametrize("how", ["command line", *further("notebook")])
def test_a_pool_of_runs_ends_whichever_step_is_interrupted(how):
    done = subprocess.run(
        [sys.executable, __file__, how, str(STRIDE)],
        env={"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=100,  # it hangs where a lock is never released
    )
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 100 * STRIDE


if __name__ == "__main__":
    how, stride = sys.argv[1], int(sys.argv[2])
    signal.signal(signal.SIGINT, signal.default_int_handler)
    commanded = how == "command line"
    number = signal.SIGTERM if commanded else signal.SIGINT
    at, ended = 1, False
    while not ended:
        watched = interruptible() if commanded else nullcontext()
        with watched, suppress(KeyboardInterrupt):
            ended = not run(at, number)
        at += stride
    sys.stdout.write(f"{at}\n")
