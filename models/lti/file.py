"""Linear systems in JSON and TOML; README.md beside this file describes the format."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.fmi.files import MOST_TEXT, parse_json, parse_toml, read_limited
from stickslip.models.errors import LtiError
from stickslip.models.lti.realisation import realise
from stickslip.models.lti.system import Array, LinearSystem

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
    LtiError
        When the file does not describe one; the message names file and key.
    OSError
        When it cannot be read.
    """
    path = Path(path)
    content = _read(path)
    try:
        return _understood(content, path.stem)
    except LtiError as error:
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
        raise LtiError(f"{path}: expected a .json or .toml file")
    try:
        data = read_limited(path, MOST_TEXT)
        content = parse_json(data) if path.suffix == ".json" else parse_toml(data)
    except ValueError as error:
        raise LtiError(f"{path}: {error}") from None
    if not isinstance(content, dict):
        raise LtiError(f"{path}: expected keys and values at the top")
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
