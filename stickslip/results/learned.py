"""learned.json: the tuned parameters with units, cost, seed and versions."""

from __future__ import annotations

import math
from importlib.metadata import version
from pathlib import Path
from typing import Any

from stickslip.catalog.parameters import LUGRE, UNITS, at_share, unit_of
from stickslip.cosim import Trapezoid
from stickslip.errors import UsageError
from stickslip.evaluation.fmpy_check import SecondOpinion
from stickslip.evaluation.guards import Worth
from stickslip.identification.estimation import Estimation
from stickslip.pipeline.reproduction import Reproduction
from stickslip.results.learned_loop import (
    datasheet_document,
    loop_document,
    read_document,
    validation_document,
)
from stickslip.servo.datasheet import VALIDATION, Datasheet
from stickslip.servo.velocity_loop import VelocityLoop

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
        "start": {
            name: {"value": known.value, "unit": UNITS[name]}
            for name, known in reproduction.start.items()
        },
        "coarse": dict(options.coarse),
        "result": learned.chosen,
        "search_skipped": learned.skipped or None,
        "cost": {"value": learned.cost, "unit": "m2/s2"},
        "best_cost_of_generations": {"value": reproduction.algorithm.best.cost, "unit": "m2/s2"},
        "cost_of_identified": {"value": reproduction.cost_of_identified, "unit": "m2/s2"},
        "cost_without_compensation": {"value": reproduction.cost_without, "unit": "m2/s2"},
        "evaluations": reproduction.algorithm.evaluations,
        "further_runs": learned.runs,
        "seed": options.seed,
        "preset": options.preset,
        "feed": options.feed,
        "loop": loop_document(reproduction.identification.loop),
        "validation": validation_document(VALIDATION),
        "second_opinion": _opinion_document(reproduction.opinion),
        "versions": versions(),
    }


def _opinion_document(opinion: SecondOpinion | None) -> dict[str, Any] | None:
    """Return what another tool computed of the same compensator, None where it was not asked."""
    if opinion is None:
        return None
    return {
        "tool": opinion.tool,
        "output": "F_mean",
        "runs": {
            name: {
                "samples": comparison.samples,
                "different": comparison.different,
                "largest_difference": {"value": comparison.largest, "unit": "N"},
            }
            for name, comparison in opinion.comparisons.items()
        },
    }


def estimation_document(
    estimation: Estimation, loop: VelocityLoop | None, seed: int
) -> dict[str, Any]:
    """Return the content of learned.json for what one recording gave, values in SI units.

    Parameters
    ----------
    loop : in which the compensator is to run, where it is known
    """
    rotary = estimation.recording.motion == "rotary"
    known = estimation.known
    parameters = {
        name: {
            "value": known[name].value,
            "unit": unit_of(name, rotary=rotary),
            "standard_error": known[name].standard_error,
            "low": known[name].low,
            "high": known[name].high,
            "visible": known[name].visible,
            "sentence": known[name].sentence,
        }
        for name in known
    }
    document: dict[str, Any] = {
        "parameters": parameters,
        "F_0": {"value": estimation.F_0, "unit": unit_of("F_c", rotary=rotary)},
        "delay": {"value": estimation.delay, "unit": "s"},
        "delta": {"value": estimation.delta, "unit": "1"},
        "log": estimation.recording.source,
        "motion": estimation.recording.motion,
        "judge": estimation.judge,
        "reason": estimation.reason,
        "relative_errors": {
            name: _finite(value) for name, value in estimation.figures.errors().items()
        },
        "evaluations": int(estimation.searches["evaluations"].sum()),
        "seed": seed,
        "spread_over_searches": estimation.spread(),
    }
    if loop is not None:
        document |= {
            "feed": "nominal",
            "loop": loop_document(loop),
            "validation": validation_document(VALIDATION),
        }
    return document | {"versions": versions()}


def trial_document(worth: Worth, command: Trapezoid, sheet: Datasheet) -> dict[str, Any]:
    """Return what learned.json tells of how a compensator was tried.

    Speeds and errors are in m/s, or rad/s for a rotary drive; an error that is not finite is null.
    """
    return {
        "share": {"value": worth.share, "unit": "1"},
        "validation": validation_document(command),
        "datasheet": datasheet_document(sheet),
        "tracking_error": [
            {
                "speed": row.speed,
                "drive": row.drive,
                "without": _finite(row.without),
                "with": _finite(row.compensated),
            }
            for row in worth.rows
        ],
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def versions() -> dict[str, str]:
    """Return the versions of the packages that the result depends on."""
    return {package: version(package) for package in PACKAGES}


def read_learned(path: Path) -> dict[str, float]:
    """Return the compensator's parameters of a learned.json by name, in SI units.

    They are those of the friction, at the ``share`` of its force that the file names.

    Raises
    ------
    UsageError
        When the file is not one.
    OSError
        When it cannot be read.
    """
    friction, entry = read_friction(path), read_document(path).get("share", {"value": 1.0})
    share = entry.get("value") if isinstance(entry, dict) else None
    if not isinstance(share, (int, float)) or not 0.0 < share <= 1.0:
        raise UsageError(f"{path}: share: expected a value above 0 and up to 1; got {entry!r:.80}")
    return at_share(friction, share)


def read_friction(path: Path) -> dict[str, float]:
    """Return the learned friction of a learned.json by name, in SI units.

    LuGre's five, and the exponent ``delta`` where the file has it.

    Raises
    ------
    UsageError
        When the file is not one.
    OSError
        When it cannot be read.
    """
    document = read_document(path)
    try:
        values = {name: float(document["parameters"][name]["value"]) for name in LUGRE}
        if "delta" in document:
            values["delta"] = float(document["delta"]["value"])
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
    for name, value in values.items():
        if not math.isfinite(value):
            raise UsageError(f"{path}: {name} is {value}; expected a finite number")
    return values
