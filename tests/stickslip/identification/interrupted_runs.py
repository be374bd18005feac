"""A signal at each step that Python takes in a pool of runs; the process hangs if one breaks it.

Prints how many steps there are. The second argument n leaves out steps: every n-th is interrupted.
"""

import signal
import sys
import time
from contextlib import nullcontext, suppress

from stickslip.identification.criteria.runs import Runs


class Idle:
    """Stands for a simulation, and for its specification."""

    def prepare(self):
        return self

    def run(self, parameters, inputs, *, until=None):
        del parameters, inputs, until
        time.sleep(1e-3)

    def close(self):
        pass


class Interrupter:
    """Sends a signal to its own process at the n-th event of tracing in the main thread."""

    def __init__(self, at, number):
        self.count, self.at, self.number = 0, at, number

    def __call__(self, frame, event, argument):
        del frame, event, argument
        self.count += 1
        if self.count == self.at:
            signal.raise_signal(self.number)
        return self


def run(at, number):
    """Return whether the signal was sent before all runs were done."""
    interrupter = Interrupter(at, number)
    sys.settrace(interrupter)
    try:
        with Runs(Idle(), 2) as runs:
            runs.each(lambda _: runs.run({}, {}), range(3))
    finally:
        sys.settrace(None)
    return interrupter.count >= at


def watched(how):
    """Return the block that a program runs in: the command line's, or a notebook's."""
    if how == "notebook":
        return nullcontext()
    from stickslip.fmi.process import interruptible

    return interruptible()


if __name__ == "__main__":
    how, stride = sys.argv[1], int(sys.argv[2])
    signal.signal(signal.SIGINT, signal.default_int_handler)
    number = signal.SIGTERM if how == "command line" else signal.SIGINT
    at, ended = 1, False
    while not ended:
        with watched(how), suppress(KeyboardInterrupt):
            ended = not run(at, number)
        at += stride
    sys.stdout.write(f"{at}\n")
