"""Runs the Python of a case, which ends as a command does: ``python python.py CODE``."""

import sys

import numpy as np
import pandas as pd

import stickslip
from stickslip import cosim
from stickslip.cli import main
from stickslip.fmi.errors import Fault


def run(code: str) -> int:
    """Run Python with ``ss``, ``np``, ``pd``, ``cosim`` and ``main``, the command line.

    A fault becomes a line on standard error; the status is that of a command.
    """
    names = {"ss": stickslip, "np": np, "pd": pd, "cosim": cosim, "main": main}
    try:
        exec(code, names)  # noqa: S102 - a case is of this project
    except Fault as fault:
        print(f"stickslip: {fault}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(run(sys.argv[1]))
