"""Parts of a recording that are held out, and whether one error is less than another there."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.servo.measurement import Array
from stickslip.thresholds import law_choice

FOLDS = 5
BLOCKS = 40  # blocks of equal duration, fewer in a short recording; every fifth is held out at once


@dataclass(frozen=True)
class Fold:
    """Samples (n,) that are fitted, and samples that are predicted."""

    fitted: NDArray[np.bool_]
    held_out: NDArray[np.bool_]


def blocks(n: int, count: int = BLOCKS) -> NDArray[np.intp]:
    """Return the block of each of n samples (n,)."""
    return np.arange(n) * count // n


def folds(n: int, memory: int) -> Iterator[Fold]:
    """Yield each fold of n samples; together they predict all of them.

    Each one holds out blocks from all over the recording, so that the rest visits the same speeds
    and reversals. The friction law runs along the whole motion, held out or not, so that its
    states have settled where a block begins. Samples nearer to a block than ``memory``, over which
    the low-pass mixes them, are neither fitted nor predicted. A block is at least as long as that,
    so that something is left to fit.
    """
    block = blocks(n, int(np.clip(n // (memory + 1), FOLDS, BLOCKS)))
    for k in range(FOLDS):
        held_out = block % FOLDS == k
        near = np.convolve(held_out, np.ones(2 * memory + 1), mode="same") > 0.5
        yield Fold(~near, held_out)


def mean_squares(residual: Array, used: NDArray[np.bool_]) -> Array:
    """Return the mean square of a residual (n,) in each block that has samples that are used."""
    block = blocks(len(residual))[used]
    count = np.bincount(block)
    return np.asarray(np.bincount(block, residual[used] ** 2)[count > 0] / count[count > 0])


def is_less(one: Array, other: Array) -> bool:
    """Tell whether mean squares (blocks,) are less than others, by the standard error over blocks.

    Either the difference of the mean squares or their ratio must be significant: where one law
    fails in few blocks only, the difference has a large standard error.
    """
    if len(one) < 2 or np.mean(one) > law_choice.MARGIN**2 * np.mean(other):
        return False
    least = np.finfo(float).tiny
    ratio = np.log(np.maximum(other, least) / np.maximum(one, least))
    return any(
        bool(np.mean(gain) > law_choice.TIE * np.std(gain, ddof=1) / np.sqrt(len(gain)))
        for gain in (other - one, ratio)
    )
