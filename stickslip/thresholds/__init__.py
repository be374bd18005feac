"""Numbers that decide, in a module for each decision.

The docstring of a module says what is decided, and the text below a threshold what lies above and
below it. Code reads a threshold when it decides, as ``harm.WORSE``, so that a test can move it:
``tests/test_thresholds.py`` shows for each of them what then changes.
"""

import ast
import inspect
import pkgutil
from collections.abc import Iterator
from importlib import import_module
from itertools import pairwise
from types import ModuleType
from typing import Self


class Threshold(float):
    """A number that decides."""

    evidence: str  # the decision, page or command with the figures behind the number
    unit: str  # of the number

    def __new__(cls, value: float, evidence: str = "not measured", unit: str = "1") -> Self:
        """Return the number with its evidence and unit."""
        found = super().__new__(cls, value)
        found.evidence, found.unit = evidence, unit
        return found


def modules() -> dict[str, ModuleType]:
    """Return the modules of the room by name."""
    names = [one.name for one in pkgutil.iter_modules(__path__)]
    return {name: import_module(f"{__name__}.{name}") for name in names}


def meanings(module: ModuleType) -> Iterator[tuple[str, Threshold, str]]:
    """Yield name, number and meaning of each threshold of a module."""
    body = ast.parse(inspect.getsource(module)).body
    for node, text in pairwise(body):
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            name = node.targets[0].id
            meaning = ast.literal_eval(text.value) if isinstance(text, ast.Expr) else ""
            yield name, getattr(module, name), inspect.cleandoc(meaning)
