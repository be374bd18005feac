"""Blocks of a recording that are held out in turn."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FOLDS = 5
BLOCKS = 40
"""Blocks of equal duration; every fifth is held out at once."""


@dataclass(frozen=True)
class Fold:
    """Samples (n,) that are fitted, and samples that are predicted."""

    fitted: NDArray[np.bool_]
    held_out: NDArray[np.bool_]


def blocks(n: int) -> NDArray[np.intp]:
    """Return the block of each of n samples (n,)."""
    return np.arange(n) * BLOCKS // n


def folds(n: int, memory: int) -> Iterator[Fold]:
    """Yield each fold of n samples; together they predict all of them.

    Each one holds out blocks from all over the recording, so that the rest visits the same speeds
    and reversals. The friction law runs along the whole motion, held out or not, so that its
    states have settled where a block begins. Samples nearer to a block than ``memory``, over which
    the low-pass mixes them, are neither fitted nor predicted.
    """
    block = blocks(n)
    for k in range(FOLDS):
        held_out = block % FOLDS == k
        near = np.convolve(held_out, np.ones(2 * memory + 1), mode="same") > 0.5
        yield Fold(~near, held_out)
