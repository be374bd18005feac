"""The content of learned.json of a reproduction."""

from collections.abc import Mapping
from typing import Any

from stickslip.catalog.parameters import start_unit, unit_of
from stickslip.evaluation.motions import VALIDATION
from stickslip.learned.writing import (
    SCHEMA,
    component_entry,
    law_entry,
    loop_document,
    validation_document,
    versions,
)
from stickslip.papers.lugre.reproduction import Reproduction
from stickslip.storage.codec import encode, state
from stickslip.tuning.drive_model import DriveModel
from stickslip.tuning.loop_runs import GENES


def reproduction_document(reproduction: Reproduction) -> dict[str, Any]:
    """Return the content of learned.json as plain data, values in SI units."""
    learned, options, opinion = reproduction.refinement, reproduction.options, reproduction.opinion
    return {
        "schema": SCHEMA,
        "parameters": state(learned.estimates, unit_of),
        "start": state({n: known.value for n, known in reproduction.start.items()}, unit_of),
        "coarse": dict(options.coarse),
        "result": learned.chosen,
        "slow_motions": learned.remark or None,
        "cost": {"value": learned.cost, "unit": "m2/s2"},
        "cost_without_compensation": {"value": reproduction.cost_without, "unit": "m2/s2"},
        "runs": learned.runs,
        "seed": options.seed,
        "preset": options.preset,
        "feed": options.feed,
        "loop": loop_document(reproduction.identification.loop),
        "loop_learning": _loop_learning_entry(reproduction),
        "validation": validation_document(VALIDATION),
        "second_opinion": opinion and {"output": "F_ff", **encode(opinion)},
        **law_entry(reproduction.identification.law),
        "versions": versions(),
    }


def _loop_learning_entry(reproduction: Reproduction) -> dict[str, Any]:
    """Return the loop that was learned, and the compensators in it."""
    best = reproduction.loops.best
    found = {
        "chosen": best.chosen,
        "seed": best.seed,
        "cost": {"value": best.cost, "unit": "1"},
        "peak_sensitivity": {"value": best.Ms, "unit": "1"},
        "evaluations": best.evaluations,
        "runs": best.runs,
        "models": [_model_entry(model) for model in reproduction.loops.study.models],
        "genes": state(best.genes, {g.name: g.unit for g in GENES}),
        "loop": loop_document(best.tuned.loop),
        "share": {"value": best.tuned.share, "unit": "1"},
        "feedforward": _friction_entry(best.tuned.law.name, best.tuned.friction),
    }
    return found | {one.name: component_entry(one, rotary=False) for one in best.tuned.chain()[1:]}


def _model_entry(model: DriveModel) -> dict[str, Any]:
    """Return a model of the drive on which candidates ran."""
    return _friction_entry(model.law, model.friction) | {
        "mismatch": {"value": model.mismatch, "unit": "1"},
        "noise_x": {"value": model.noise, "unit": "m"},
    }


def _friction_entry(law: str, friction: Mapping[str, float]) -> dict[str, Any]:
    return {"law": law, "parameters": state(friction, start_unit)}
