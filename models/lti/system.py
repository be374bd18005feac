"""A linear system with named variables, from python-control, JSON or TOML (see README.md)."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.fmi.by_name import by_name
from stickslip.fmi.files import MOST_TEXT, parse_json, parse_toml, read_limited
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


_KEYS = (
    *("name", "A", "B", "C", "D", "num", "den", "dt"),
    *("inputs", "outputs", "states", "x0", "step", "stop"),
)


@dataclass(frozen=True)
class LtiFile:
    """What a file holds; ``step`` and ``stop`` [s] are None where it proposes none."""

    system: LinearSystem
    step: float | None
    stop: float | None


def read_lti(path: Path | str) -> LtiFile:
    """Read a linear system from a ``.json`` or ``.toml`` file.

    Raises
    ------
    LtiError, OSError
        When the file does not describe one, or cannot be read; the message names file and key.
    """
    path = Path(path)
    try:
        return _understood(_read(path), path.stem)
    except ValueError as error:
        raise LtiError(f"{path}: {error}") from None


def _understood(content: Mapping[str, Any], name: str) -> LtiFile:
    if unknown := sorted(content.keys() - set(_KEYS)):
        raise LtiError(f"unknown key {unknown[0]!r}; known are {', '.join(_KEYS)}")
    A, B, C, D = _transfer(content) if "num" in content else _state_space(content)
    system = LinearSystem(
        str(content.get("name", name)),
        *(A, B, C, D),
        dt=_seconds(content, "dt") or 0.0,
        inputs=_names(content, "inputs", "u", D.shape[1]),
        outputs=_names(content, "outputs", "y", len(D)),
        states=_names(content, "states", "x", len(A)),
        x0=_matrix(content.get("x0", [0.0] * len(A)), "x0", 1),
    )
    return LtiFile(system, _seconds(content, "step"), _seconds(content, "stop"))


def _read(path: Path) -> Mapping[str, Any]:
    if path.suffix not in (".json", ".toml"):
        raise LtiError("expected a .json or .toml file")
    data = read_limited(path, MOST_TEXT)
    content = parse_json(data) if path.suffix == ".json" else parse_toml(data)
    if not isinstance(content, dict):
        raise LtiError("expected keys and values at the top")
    return content


def _state_space(content: Mapping[str, Any]) -> tuple[Array, Array, Array, Array]:
    if "D" not in content and "C" not in content:
        raise LtiError("expected A, B, C and D, or num and den")
    A = _matrix(content.get("A", []), "A", 2)
    C = _matrix(content.get("C", []), "C", 2)
    B = _matrix(content.get("B", []), "B", 2)
    D = _matrix(content["D"], "D", 2) if "D" in content else np.zeros((len(C), B.shape[1]))
    n, (p, m) = len(A), D.shape
    return A, B if B.size else np.zeros((n, m)), C if C.size else np.zeros((p, n)), D


def _transfer(content: Mapping[str, Any]) -> tuple[Array, Array, Array, Array]:
    """Return states for one polynomial each, or for rows of them: [output][input]."""
    num, den = content["num"], content.get("den")
    if den is None:
        raise LtiError("den is missing beside num")
    if isinstance(num, list) and num and not isinstance(num[0], list):
        num, den = [[num]], [[den]]
    if not (isinstance(num, list) and isinstance(den, list)):
        raise LtiError("num and den are no lists of coefficients")
    try:
        shapes = {(len(num), len(row)) for rows in (num, den) for row in rows}
        if len(num) != len(den) or len(shapes) != 1:
            raise LtiError("num and den differ in outputs or inputs")
        for rows, name in ((num, "num"), (den, "den")):
            for row in rows:
                for polynomial in row:
                    if not _matrix(polynomial, name, 1).any() and name == "den":
                        raise LtiError("den holds a polynomial that is 0")
    except TypeError:
        raise LtiError("num and den: expected lists of coefficients, [output][input]") from None
    with np.errstate(all="ignore"):  # what overflows is refused as not finite
        return realise(num, den)


def _matrix(value: Any, name: str, dimensions: int) -> Array:
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise LtiError(f"{name}: expected numbers in rows of equal length") from None
    if not np.isfinite(array).all():
        raise LtiError(f"{name}: holds a number that is not finite")
    if not array.size:
        return np.zeros((0,) * dimensions)
    if array.ndim != dimensions:
        shape = "rows of numbers, [[...], ...]" if dimensions == 2 else "a list of numbers"
        raise LtiError(f"{name}: expected {shape}")
    return array


def _seconds(content: Mapping[str, Any], key: str) -> float | None:
    value = content.get(key)
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise LtiError(f"{key} is {value!r}; expected a number of seconds")
    return float(value)


def _names(content: Mapping[str, Any], key: str, letter: str, n: int) -> dict[str, str | None]:
    """Return name -> unit of a table, of a list of names, or of ``letter[0]`` ... by default."""
    given = content.get(key, [f"{letter}[{k}]" for k in range(n)])
    if not isinstance(given, list | dict) or not all(isinstance(name, str) for name in given):
        raise LtiError(f"{key}: expected a list of names, or a table of names and units")
    names = dict.fromkeys(given) if isinstance(given, list) else given
    if len(names) != n or len(given) != n:
        raise LtiError(f"{key}: {len(given)} names for {n}; expected a different one for each")
    for name, unit in names.items():
        if not isinstance(unit, str | None):
            raise LtiError(f"{key}: the unit of {name!r} is {unit!r:.40}; expected a text")
    return {name: unit or None for name, unit in names.items()}
