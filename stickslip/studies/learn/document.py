"""The content of learned.json of a recording or log: what was learned, and how it was tried."""

from dataclasses import replace
from functools import partial
from typing import Any

from stickslip.catalog.parameters import start_unit, unit_of
from stickslip.evaluation.motions import VALIDATION
from stickslip.learned import writing
from stickslip.models import load_model
from stickslip.models.export.units import motion_unit
from stickslip.output import plain
from stickslip.servo.systems import Compensator
from stickslip.storage.codec import encode, state
from stickslip.studies.learn import tables
from stickslip.studies.learn.learned import LearnedFromRecording
from stickslip.thresholds import position_force
from stickslip.trial.benefit import Benefit
from stickslip.trial.candidates import Row


def recording_document(learned: LearnedFromRecording) -> dict[str, Any]:
    """Return the content of learned.json for what one recording gave, values in SI units."""
    estimation, loop = learned.estimation, learned.known_loop
    rotary = estimation.recording.rotary
    errors = estimation.errors
    document: dict[str, Any] = {
        "schema": writing.SCHEMA,
        "parameters": tables.parameters(estimation).by_key(),
        "F_0": {
            "value": estimation.parameters["F_0"],
            "unit": unit_of("F_c", rotary=rotary),
            "standard_error": errors.get("F_0", 0.0),
        },
        "delay": {
            "value": estimation.parameters["delay"],
            "unit": "s",
            "standard_error": errors.get("delay", 0.0),
        },
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
        "evaluations": estimation.searched.evaluations,
        "seed": learned.seed,
    }
    if learned.hashes:
        document["sha256"] = dict(learned.hashes)
    if learned.predicted:
        document["predicted_logs"] = tables.predicted_logs(
            learned.predicted, rotary=rotary
        ).records()
    if (curve := estimation.start.curve) is not None:  # with viscous friction, 95 % intervals
        speed, force = unit_of("v_s", rotary=rotary), unit_of("F_c", rotary=rotary)
        friction = {key: plain(getattr(curve, key)) for key in ("value", "low", "high")}
        document["friction_curve"] = {
            "speed": state(curve.speed, speed),
            "friction": {**friction, "unit": force},
            "offset": state(curve.offset, force),
        }
    if estimation.position_force is not None:
        document["position_force"] = tables.position_force(estimation).by_key()
    if loop is not None:
        document |= {
            "loop": writing.loop_document(loop),
            "validation": writing.validation_document(VALIDATION, rotary=rotary),
        }
    return document | writing.law_entry(estimation.law) | {"versions": writing.versions()}


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
    trial, benefit = learned.trial, learned.benefit
    if trial is None or benefit is None:
        return document
    of_law, chosen = learned.of_law or trial.benefit, trial.compared.chosen
    if trial.holds:
        document["hold"] = encode(trial.holds, of_drive)
    if tried := learned.other_gains:
        document["other_gains"] = encode(tried) | {"sentence": tried.sentence}
    document |= {
        "share": _share_entry(of_law),
        "compensator": state(of_law.variant.feedforward, start_unit, of_drive),
        "compensation": learned.choice,
        "compared": {
            "chosen": chosen.name,
            "sentence": trial.compared.sentence,
            "compensators": tables.compensators(trial.compared).records(),
        },
    }
    if chosen.benefit:
        document["predicted_error"] = tables.predicted(chosen.benefit).records()
    one = learned.feedforward
    if (one.model, one.law) != trial.benefit.variant.feedforward_kind:
        entry = writing.component_entry(one, rotary=rotary)
        document["feedforward"] = entry | {"share": _share_entry(benefit)}
    return document | {
        "observer": _observer_entry(learned, chosen, rotary=rotary),
        "validation": writing.validation_document(trial.command, rotary=rotary),
        "datasheet": encode(trial.datasheet, of_drive),
        "family": encode(trial.drives, of_drive),
        "tracking_error": plain(trial.table()),
    }


def loaded(observer: Compensator, learned: LearnedFromRecording) -> Compensator:
    """Return an observer that leaves a weight, which the drives of the trial lack, to the loop."""
    F_0, known = learned.estimation.parameters["F_0"], load_model(observer.model).variables
    is_weight = abs(F_0) > position_force.HELD * learned.friction["F_c"]
    if learned.position_force or not is_weight or all(one.name != "F_0" for one in known):
        return observer
    return replace(observer, values={**observer.values, "F_0": F_0})


def _share_entry(benefit: Benefit) -> dict[str, Any]:
    """Return the share of the whole force, and why it is not the whole."""
    reason = {"reason": benefit.reason} if benefit.share < 1.0 else {}
    return {"value": benefit.share, "unit": "1", **reason}


def _observer_entry(learned: LearnedFromRecording, chosen: Row, *, rotary: bool) -> dict[str, Any]:
    """Return the observer that is written, or why there is none."""
    entry: dict[str, Any] = {"refusal": learned.observer_refusal}
    if designed := chosen.designed:
        component = writing.component_entry(loaded(designed.observer, learned), rotary=rotary)
        if component["model"] == writing.OBSERVER_MODEL:
            del component["model"]
        entry |= {
            **component,
            "peak_sensitivity": {"value": designed.sensitivity, "unit": "1"},
            "peak_sensitivity_without": {"value": designed.without, "unit": "1"},
        }
    return entry
