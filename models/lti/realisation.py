"""States for transfer functions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.models.errors import LtiError

Array = NDArray[np.float64]


def realise(
    numerators: Sequence[Sequence[Any]], denominators: Sequence[Sequence[Any]]
) -> tuple[Array, Array, Array, Array]:
    """Return A, B, C, D of the transfer functions [output][input], highest power first.

    Outputs that share an input and its denominator share states, in controllable canonical form.

    Raises
    ------
    LtiError
        When one is improper, or its coefficients are not real.
    """
    outputs, inputs = len(numerators), len(numerators[0])
    blocks = []
    D = np.zeros((outputs, inputs))
    for k in range(inputs):
        columns: dict[tuple[float, ...], list[int]] = {}
        for i in range(outputs):
            columns.setdefault(tuple(_trimmed(denominators[i][k])), []).append(i)
        for denominator, rows in columns.items():
            numerator = np.zeros((len(rows), len(denominator)))
            for row, i in enumerate(rows):
                polynomial = _trimmed(numerators[i][k])
                if len(polynomial) > len(denominator):
                    raise LtiError(
                        f"the transfer function from input {k + 1} to output {i + 1} is improper:"
                        f" its numerator has the order {len(polynomial) - 1}, its denominator"
                        f" {len(denominator) - 1}"
                    )
                numerator[row, len(denominator) - len(polynomial) :] = polynomial
            numerator /= denominator[0]
            D[rows, k] = numerator[:, 0]
            if len(denominator) > 1:
                blocks.append((k, rows, *_canonical(numerator, np.array(denominator))))
    from scipy.linalg import block_diag  # late, for those who start quickly

    n = sum(len(A) for _, _, A, _ in blocks)
    B, C, place = np.zeros((n, inputs)), np.zeros((outputs, n)), 0
    for k, rows, A, rows_of_C in blocks:
        B[place, k] = 1.0
        C[rows, place : place + len(A)] = rows_of_C
        place += len(A)
    return block_diag(*(A for _, _, A, _ in blocks)) if n else np.zeros((0, 0)), B, C, D


def _canonical(numerator: Array, denominator: Array) -> tuple[Array, Array]:
    """Return A (n, n), whose input feeds the first state, and C (outputs, n)."""
    monic = denominator / denominator[0]
    A = np.eye(len(monic) - 1, k=-1)
    A[0] = -monic[1:]
    return A, numerator[:, 1:] - np.outer(numerator[:, 0], monic[1:])


def _trimmed(coefficients: Any) -> Array:
    """Return the coefficients without leading zeros; one 0 remains of none but zeros."""
    values = np.atleast_1d(np.asarray(coefficients))
    if np.iscomplexobj(values):
        raise LtiError("a transfer function has coefficients that are not real")
    return np.asarray(np.trim_zeros(values.astype(float), "f") if values.any() else np.zeros(1))
