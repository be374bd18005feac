"""Learns with a checkpoint, in a process that is there to be killed: CHECKPOINT HISTORY."""

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
from problems import GENES, sometimes_fails

from stickslip import ga


def slowly(values: np.ndarray) -> float:
    time.sleep(2e-3)
    return sometimes_fails(values)


if __name__ == "__main__":
    checkpoint, history = sys.argv[1:]
    optimiser = ga.optimiser("default", ga.Problem(GENES), ga.Limits(evaluations=300), seed=3)
    ga.learn(optimiser, slowly, checkpoint=checkpoint, resume=True)
    optimiser.history.to_csv(history)
