"""The content of learned.json of a recording or log: what was learned, and how it was tried."""

from __future__ import annotations

from functools import partial
from typing import Any

from stickslip.catalog.parameters import start_unit, unit_of
from stickslip.evaluation.motions import VALIDATION
from stickslip.identification.sliding.friction_curve import FrictionCurve
from stickslip.learned.writing import (
    OBSERVER_MODEL,
    SCHEMA,
    component_entry,
    law_entry,
    loop_document,
    validation_document,
    versions,
)
from stickslip.models.export.units import motion_unit
from stickslip.output import plain
from stickslip.storage.codec import encode, state
from stickslip.studies.learn import tables
from stickslip.studies.learn.learned import LearnedFromRecording


def recording_document(learned: LearnedFromRecording) -> dict[str, Any]:
    """Return the content of learned.json for what one recording gave, values in SI units."""
    estimation, loop = learned.estimation, learned.known_loop
    rotary = estimation.recording.rotary
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "parameters": tables.parameters(estimation).by_key(),
        "F_0": {"value": estimation.F_0, "unit": unit_of("F_c", rotary=rotary)},
        "delay": {"value": estimation.delay, "unit": "s"},
        "T_s": {"value": estimation.recording.T_s, "unit": "s"},
        **state(estimation.chosen, partial(unit_of, rotary=rotary)),
        "log": estimation.recording.source,
        "motion": estimation.recording.motion,
        "criterion": estimation.criterion,
        "reason": estimation.reason,
        "relative_errors": encode(estimation.figures.errors()),
        "prediction": {
            "laws": tables.laws(estimation).records(),
            "choice": estimation.choice and estimation.choice.reason,
        },
        "evaluations": int(estimation.searches.table["evaluations"].sum()),
        "seed": learned.seed,
        "spread_over_searches": estimation.spread(),
    }
    if estimation.friction_curve is not None:
        document["friction_curve"] = curve_document(estimation.friction_curve, rotary=rotary)
    if loop is not None:
        document |= {
            "feed": "nominal",
            "loop": loop_document(loop),
            "validation": validation_document(VALIDATION, rotary=rotary),
        }
    return document | law_entry(estimation.law) | {"versions": versions()}


def curve_document(curve: FrictionCurve, *, rotary: bool) -> dict[str, Any]:
    """Return friction at the speeds visited with its 95 % intervals, viscous friction with it."""
    speed, force = unit_of("v_s", rotary=rotary), unit_of("F_c", rotary=rotary)
    friction = {key: plain(getattr(curve, key)) for key in ("value", "low", "high")}
    return {
        "speed": state(curve.speed, speed),
        "friction": {**friction, "unit": force},
        "offset": state(curve.offset, force),
    }


def log_document(learned: LearnedFromRecording) -> dict[str, Any]:
    """Return the content of learned.json for a log, with how the compensator was tried.

    Speeds and errors are in m/s, or rad/s for a rotary drive; an error that is not finite is null.
    """
    document = recording_document(learned) | {"refusal": learned.refusal}
    rotary = learned.estimation.recording.rotary
    of_drive = partial(motion_unit, rotary=rotary)
    if learned.tracking is not None:
        tracking = learned.tracking
        document["tracking"] = {
            "loop": tracking.loop,
            "command": tracking.command,
            "measured": encode(tracking.measured),
            "simulated": encode(tracking.errors()),
        }
    if learned.trial is None:
        return document
    trial, benefit = learned.trial, learned.of_law or learned.trial.benefit
    if trial.holds:
        document["hold"] = encode(trial.holds, of_drive)
    if tried := learned.other_gains:
        document["other_gains"] = encode(tried) | {"sentence": tried.sentence}
    return document | {
        "share": {"value": benefit.share, "unit": "1"},
        "compensator": state(benefit.variant.feedforward, start_unit, of_drive),
        **_feedforward_entry(learned),
        **_observer_entry(learned),
        "validation": validation_document(trial.command, rotary=rotary),
        "datasheet": encode(trial.datasheet, of_drive),
        "family": encode(trial.drives, of_drive),
        "tracking_error": plain(trial.table()),
    }


def _feedforward_entry(learned: LearnedFromRecording) -> dict[str, Any]:
    """Return all compensators that were tried, what is written, and its predicted error."""
    if learned.trial is None or learned.benefit is None:
        return {}
    compared, one, benefit = learned.trial.compared, learned.feedforward, learned.benefit
    found: dict[str, Any] = {
        "compensation": learned.choice,
        "compared": {
            "chosen": compared.chosen.name,
            "sentence": compared.sentence,
            "compensators": tables.compensators(compared).records(),
        },
    }
    if compared.chosen.benefit:
        found["predicted_error"] = tables.predicted(compared.chosen.benefit).records()
    if (one.model, one.law) != learned.trial.benefit.variant.feedforward_kind:
        component = component_entry(one, rotary=learned.estimation.recording.rotary)
        found["feedforward"] = component | {"share": {"value": benefit.share, "unit": "1"}}
    return found


def _observer_entry(learned: LearnedFromRecording) -> dict[str, Any]:
    """Return the observer that is written, or why there is none."""
    if learned.trial is None:
        return {}
    entry: dict[str, Any] = {"refusal": learned.observer_refusal}
    if designed := learned.trial.compared.chosen.designed:
        rotary = learned.estimation.recording.rotary
        component = component_entry(designed.observer, rotary=rotary)
        if component["model"] == OBSERVER_MODEL:
            del component["model"]
        entry |= {
            **component,
            "peak_sensitivity": {"value": designed.sensitivity, "unit": "1"},
            "peak_sensitivity_without": {"value": designed.without, "unit": "1"},
        }
    return {"observer": entry}
