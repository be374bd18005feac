"""A signal at each step that Python takes in a pool of runs; the process hangs if one breaks it.

Prints how many steps there are. The second argument n leaves out steps: every n-th is interrupted.
"""

import signal
import sys
import time
from contextlib import nullcontext, suppress
from types import SimpleNamespace

from stickslip.fmi.process import interruptible
from stickslip.identification.criteria.runs import Runs

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
