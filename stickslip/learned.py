"""learned.json: the tuned parameters with units, cost, seed and versions."""

from __future__ import annotations

import json
from importlib.metadata import version
from pathlib import Path
from typing import Any

from stickslip.errors import UsageError
from stickslip.learned_loop import loop_document, validation_document
from stickslip.parameters import LUGRE, UNITS
from stickslip.reproduction import Reproduction
from stickslip.setup import VALIDATION

PACKAGES = ("stickslip", "control", "fmpy", "numpy", "scipy", "ziglang")


def learned_document(reproduction: Reproduction) -> dict[str, Any]:
    """Return the content of learned.json as plain data, values in SI units."""
    learned, options = reproduction.learned, reproduction.options
    return {
        "parameters": {
            name: {
                "value": estimate.value,
                "unit": UNITS[name],
                "standard_error": estimate.standard_error,
            }
            for name, estimate in learned.estimates.items()
        },
        "cost": {"value": learned.cost, "unit": "m2/s2"},
        "best_cost_of_generations": {"value": reproduction.algorithm.best.cost, "unit": "m2/s2"},
        "evaluations": reproduction.algorithm.evaluations,
        "further_runs": learned.runs,
        "seed": options.seed,
        "preset": options.preset,
        "feed": options.feed,
        "loop": loop_document(reproduction.identification.loop),
        "validation": validation_document(VALIDATION),
        "versions": {package: version(package) for package in PACKAGES},
    }


def read_learned(path: Path) -> dict[str, float]:
    """Return the five parameters of a learned.json by name, in SI units.

    Raises
    ------
    UsageError
        When the file is not one.
    OSError
        When it cannot be read.
    """
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        return {name: float(document["parameters"][name]["value"]) for name in LUGRE}
    except (ValueError, KeyError, TypeError) as error:
        reason = str(error)
        if isinstance(error, KeyError):
            reason = f"{error} is missing"
        elif isinstance(error, TypeError):
            reason = "it has another structure"
        raise UsageError(
            f"{path}: not a learned.json: {reason}; expected parameters {', '.join(LUGRE)}, "
            "each with a value"
        ) from None
