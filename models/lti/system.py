"""A linear system with named variables, from python-control."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.fmi.by_name import by_name
from stickslip.models.errors import LtiError

Array = NDArray[np.float64]


def realise(
    numerators: Sequence[Sequence[Any]], denominators: Sequence[Sequence[Any]]
) -> tuple[Array, Array, Array, Array]:
    """Return A, B, C, D of the transfer functions [output][input], highest power first.

    Outputs that share an input and its denominator share states, in controllable canonical form.
    LtiError when one is improper, or its coefficients are not real.
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
                    orders = f"{len(polynomial) - 1}, its denominator {len(denominator) - 1}"
                    what = f"the transfer function from input {k + 1} to output {i + 1} is improper"
                    raise LtiError(f"{what}: its numerator has the order {orders}")
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


_IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_LONGEST = 255
"""Characters of a name."""


@dataclass(frozen=True, eq=False)
class LinearSystem:
    """dx/dt = A x + B u, y = C x + D u; or x+ = A x + B u at each sample.

    Attributes
    ----------
    name : a C identifier
    A, B, C, D : (n, n), (n, m), (p, n), (p, m)
    dt : sample period [s]; 0 in continuous time
    inputs, outputs, states : name -> unit, None where it has none; m, p and n of them
    x0 : (n,) state at the start

    Raises
    ------
    LtiError
        When sizes do not fit, a number is not finite, or a name is taken or empty.
    """

    name: str
    A: Array
    B: Array
    C: Array
    D: Array
    dt: float
    inputs: Mapping[str, str | None]
    outputs: Mapping[str, str | None]
    states: Mapping[str, str | None]
    x0: Array

    def __post_init__(self) -> None:
        n, m, p = len(self.states), len(self.inputs), len(self.outputs)
        shapes = {"A": (n, n), "B": (n, m), "C": (p, n), "D": (p, m), "x0": (n,)}
        for field, shape in shapes.items():
            matrix = getattr(self, field)
            if matrix.shape != shape:
                raise LtiError(f"{self.name}: {field} is {matrix.shape}, expected {shape}")
            if not np.isfinite(matrix).all():
                raise LtiError(f"{self.name}: {field} holds a number that is not finite")
        if not (np.isfinite(self.dt) and self.dt >= 0.0):
            raise LtiError(f"{self.name}: dt is {self.dt} s; expected 0 or a sample period above 0")
        if not _IDENTIFIER.fullmatch(self.name):
            raise LtiError(f"{self.name!r} cannot name an FMU: letters, digits and _ only")
        if not p:
            raise LtiError(f"{self.name}: it has no output")
        names = ["time", *self.inputs, *self.outputs, *self.states]
        for name in names:
            if not name.strip() or not name.isprintable() or names.count(name) > 1:
                raise LtiError(f"{self.name}: {name!r} cannot name a variable: empty or taken")
            if len(name) > _LONGEST:
                what = f"{len(name)} characters, expected at most {_LONGEST}"
                raise LtiError(f"{self.name}: {name[:20]!r}... cannot name a variable: {what}")


def linear_system(
    system: Any,
    *,
    name: str | None = None,
    units: Mapping[str, str] | None = None,
    x0: ArrayLike | None = None,
) -> LinearSystem:
    """Take a state space or transfer function of python-control, with its names.

    LtiError when it is neither, is improper, has no sample period though it is discrete, or has no
    variable of a name in ``units``.

    Parameters
    ----------
    name : instead of the system's own
    units : of inputs, outputs and states by name
    x0 : (n,) state at the start; 0 by default
    """
    import control  # late, for those who start quickly

    if isinstance(system, control.TransferFunction):
        A, B, C, D = realise(*control.tfdata(system))
        states: Sequence[str] = [f"x[{i}]" for i in range(len(A))]
    elif isinstance(system, control.StateSpace):
        A, B, C, D = (np.array(m, dtype=float) for m in (system.A, system.B, system.C, system.D))
        states = system.state_labels
    else:
        what = "expected a StateSpace or TransferFunction of python-control"
        advice = "linearise a nonlinear one first"
        raise LtiError(f"{type(system).__name__} is no linear system: {what}; {advice}")
    if system.dt is True:
        what = "it is discrete, but its sample period is not given (dt=True)"
        raise LtiError(f"{system.name}: {what}")
    known = [*system.input_labels, *system.output_labels, *states]
    given = by_name("units", units, LtiError)
    for unknown in given.keys() - set(known):
        raise LtiError(f"{system.name} has no variable {unknown!r}; it has {', '.join(known)}")
    own = system.name if _IDENTIFIER.fullmatch(system.name or "") else "lti"
    return LinearSystem(
        name or own,
        *(A, B, C, D),
        dt=float(system.dt or 0.0),
        inputs=_with_units(system.input_labels, given),
        outputs=_with_units(system.output_labels, given),
        states=_with_units(states, given),
        x0=np.zeros(len(states)) if x0 is None else np.array(x0, dtype=float),
    )


def _with_units(names: Sequence[str], units: Mapping[str, str]) -> dict[str, str | None]:
    return {name: units.get(name) for name in names}
