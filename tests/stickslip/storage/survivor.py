"""Counts, in a process of its own that can fork, what sets of results survive; writes JSON."""

import json
import os
import sys
from functools import partial
from pathlib import Path

from campaigns.survival.trials import (
    NEW,
    OLD,
    fill_at_each_operation,
    kill_at_each_operation,
    kill_at_random,
    remove_at_random,
    write,
)

if __name__ == "__main__":
    os.fsync = lambda _: None  # only slows the test: the machine is not switched off
    folder = Path(sys.argv[1])
    writes = (partial(write, OLD), partial(write, NEW))
    found = {
        "killed at each operation": kill_at_each_operation(folder / "a", OLD, NEW),
        "killed at random": kill_at_random(folder / "b", writes, 8),
        "full once": fill_at_each_operation(folder / "c", OLD, NEW, stays=False),
        "full for good": fill_at_each_operation(folder / "d", OLD, NEW, stays=True),
        "removed": remove_at_random(folder / "e", NEW, 8),
    }
    json.dump(found, sys.stdout)
