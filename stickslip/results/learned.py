"""learned.json: the one module that writes and reads it.

    "parameters": {"F_s": {"value": 8.98, "unit": "N", "low": 8.89, "high": 9.08, ...}, ...}
    "loop": {"K_p": {"value": 4717.4, "unit": "N.s/m"}, ...}     absent in older files
    "validation": {"height": {"value": 0.04, "unit": "m/s"}, ...}
    "datasheet": {"encoder_step": {"value": 4e-7, "unit": "m"}, ...}

Values are in SI units. The loop has m b tau_i T_s tau_f K_p K_i, and where they are used m_ff,
the gains L_x L_v L_d of a velocity filter, and K_x velocity_feedforward of a cascade. ``law`` names
the friction law where it is not LuGre.
``components`` has compensators that learn while they run, and all their parameters as numbers in
SI units: {"scale": {"model": "adaptive_scale", "parameters": {"s_0": 0.8, "rate": 0.05, ...}}}.
Only ``parameters`` is needed to read a file. ``schema`` counts changes of keys: 1, that of files
without it, has ``judge`` and ``visible`` where 2 has ``criterion`` and ``identifiability``.
"""

from __future__ import annotations

import dataclasses
import json
import math
import re
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any, cast

import numpy as np
import pandas as pd

from stickslip.catalog.parameters import estimated, friction_law, start_unit, unit_of
from stickslip.cosim import SignalError, Simulation, Trapezoid
from stickslip.errors import UsageError
from stickslip.evaluation.fmpy_check import SecondOpinion
from stickslip.evaluation.guards import Drive, Hold, Known, family
from stickslip.evaluation.tracking import Tracking
from stickslip.fmi.files import MOST_TEXT, atomic_write, parse_json, read_limited
from stickslip.identification.estimation import Estimation
from stickslip.identification.selection import law_table
from stickslip.identification.sliding.friction_curve import FrictionCurve
from stickslip.models import Law, Model, StartValueError, UnknownLaw, UnknownModel, load_model
from stickslip.models.export.units import motion_unit
from stickslip.pipeline.learned import LearnedFromRecording
from stickslip.pipeline.reproduction import Reproduction
from stickslip.servo.axis import Axis
from stickslip.servo.datasheet import LOOP, Datasheet
from stickslip.servo.deployment import deployed
from stickslip.servo.paper_commands import VALIDATION
from stickslip.servo.systems import COMPONENTS, FEEDS, Compensator, Feed
from stickslip.servo.velocity_filter import VelocityFilter
from stickslip.servo.velocity_loop import VelocityLoop, close_velocity_loop
from stickslip.tuning.drive_model import DriveModel
from stickslip.tuning.loop_genes import GENES
from stickslip.versions import installed_versions

SCHEMA = 2
"""Version of the keys that this module writes, and the latest that it reads."""
OBSERVER_MODEL = "dob"
"""Model of an observer without an entry for it."""
PACKAGES = ("stickslip", "control", "fmpy", "numpy", "scipy", "ziglang")
IDENTIFIABILITY = ("standard_error", "low", "high", "identifiability", "sentence")
LOOP_UNITS = {
    "m": "kg",
    "b": "N.s/m",
    "tau_i": "s",
    "T_s": "s",
    "tau_f": "s",
    "K_p": "N.s/m",
    "K_i": "N/m",
    "m_ff": "kg",
    "K_x": "1/s",
    "velocity_feedforward": "1",
    "L_x": "1",
    "L_v": "1/s",
    "L_d": "N/m",
}
DATASHEET = {"peak_force": "N", "tau_i": "s", "encoder_step": "m", "encoder_noise": "m"}
TRAPEZOID = {"height": "m/s", "slope": "m/s2", "plateau": "s", "begin": "s"}
_UNITS = {"loop": LOOP_UNITS, "validation": TRAPEZOID, "datasheet": DATASHEET}
_GAINS = ("L_x", "L_v", "L_d")
_AXIS = ("m", "b", "tau_i")
_LOOP = ("T_s", "tau_f", "K_p", "K_i")
_NAME = re.compile(r"[A-Za-z]\w*", re.ASCII)
_UNFIT = (AttributeError, KeyError, TypeError, ValueError, OverflowError)
"""What an entry of the wrong shape raises."""
_OUTER = ("K_x", "velocity_feedforward")


def reproduction_document(reproduction: Reproduction) -> dict[str, Any]:
    """Return the content of learned.json as plain data, values in SI units."""
    learned, options, opinion = reproduction.refinement, reproduction.options, reproduction.opinion
    return {
        "schema": SCHEMA,
        "parameters": {
            name: {
                "value": estimate.value,
                "unit": unit_of(name),
                "standard_error": estimate.standard_error,
            }
            for name, estimate in learned.estimates.items()
        },
        "start": {
            name: {"value": known.value, "unit": unit_of(name)}
            for name, known in reproduction.start.items()
        },
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
        "second_opinion": opinion and _opinion_document(opinion),
        **_law_entry(reproduction.identification.law),
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
        "models": [_model_entry(model) for model in reproduction.loops.models],
        "genes": _stated(best.genes, {g.name: g.unit for g in GENES}, rotary=False),
        "loop": loop_document(best.tuned.loop),
        "share": {"value": best.tuned.share, "unit": "1"},
    }
    return found | {one.name: _component(one, rotary=False) for one in best.tuned.chain()[1:]}


def _model_entry(model: DriveModel) -> dict[str, Any]:
    """Return a model of the drive on which candidates ran."""
    units = {name: start_unit(name) for name in model.friction}
    return {
        "law": model.law,
        "mismatch": {"value": model.mismatch, "unit": "1"},
        "noise_x": {"value": model.noise, "unit": "m"},
        "parameters": _stated(model.friction, units, rotary=False),
    }


def _law_entry(law: Law) -> dict[str, str]:
    """Return the name of the compensator's friction law; a file without it has LuGre's."""
    return {} if law.name == "lugre" else {"law": law.name}


def _opinion_document(opinion: SecondOpinion) -> dict[str, Any]:
    runs = {
        name: {
            "samples": one.samples,
            "different": one.different,
            "largest_difference": {"value": one.largest, "unit": "N"},
        }
        for name, one in opinion.comparisons.items()
    }
    return {"tool": opinion.tool, "output": "F_ff", "runs": runs}


def recording_document(learned: LearnedFromRecording) -> dict[str, Any]:
    """Return the content of learned.json for what one recording gave, values in SI units."""
    estimation, loop = learned.estimation, learned.known_loop
    rotary = estimation.recording.rotary
    known = estimation.known
    parameters = {
        name: {"value": value.value, "unit": unit_of(name, rotary=rotary)}
        | {key: getattr(value, key) for key in IDENTIFIABILITY}
        for name, value in known.items()
    }
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "parameters": parameters,
        "F_0": {"value": estimation.F_0, "unit": unit_of("F_c", rotary=rotary)},
        "delay": {"value": estimation.delay, "unit": "s"},
        "T_s": {"value": estimation.recording.T_s, "unit": "s"},
        **{
            name: {"value": value, "unit": unit_of(name, rotary=rotary)}
            for name, value in estimation.chosen.items()
        },
        "log": estimation.recording.source,
        "motion": estimation.recording.motion,
        "criterion": estimation.criterion,
        "reason": estimation.reason,
        "relative_errors": {
            name: _finite(value) for name, value in estimation.figures.errors().items()
        },
        "prediction": _prediction_document(estimation),
        "evaluations": int(estimation.searches["evaluations"].sum()),
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
    return document | _law_entry(estimation.law) | {"versions": versions()}


def _prediction_document(estimation: Estimation) -> dict[str, Any]:
    """Return the force error of each law that was tried where it was not fitted."""
    unit = unit_of("F_c", rotary=estimation.recording.rotary)
    laws = [
        {
            "law": row["law"],
            "held_out_error": {"value": row["held_out_error"], "unit": unit},
            "relative": {"value": row["relative"], "unit": "1"},
            "explained": {"value": row["explained"], "unit": unit},
        }
        for row in law_table(estimation.predictions).to_dict("records")
    ]
    return {"laws": laws, "choice": estimation.choice and estimation.choice.reason}


def curve_document(curve: FrictionCurve, *, rotary: bool) -> dict[str, Any]:
    """Return friction at the speeds visited with its 95 % intervals, viscous friction with it."""
    speed, force = unit_of("v_s", rotary=rotary), unit_of("F_c", rotary=rotary)
    friction = {key: getattr(curve, key).tolist() for key in ("value", "low", "high")}
    return {
        "speed": {"value": curve.speed.tolist(), "unit": speed},
        "friction": {**friction, "unit": force},
        "offset": {**vars(curve.offset), "unit": force},
    }


def log_document(learned: LearnedFromRecording) -> dict[str, Any]:
    """Return the content of learned.json for a log, with how the compensator was tried.

    Speeds and errors are in m/s, or rad/s for a rotary drive; an error that is not finite is null.
    """
    document = recording_document(learned) | {"refusal": learned.refusal}
    rotary = learned.estimation.recording.rotary
    if learned.tracking is not None:
        document["tracking"] = _tracking_document(learned.tracking)
    if learned.trial is None:
        return document
    trial, benefit = learned.trial, learned.of_law or learned.trial.benefit
    if trial.holds:
        document["hold"] = {name: _hold_document(one) for name, one in trial.holds.items()}
    return document | {
        "share": {"value": benefit.share, "unit": "1"},
        "compensator": _with_units(benefit.variant.feedforward, rotary=rotary),
        **_feedforward_entry(learned),
        **_observer_entry(learned),
        "validation": validation_document(trial.command, rotary=rotary),
        "datasheet": datasheet_document(trial.datasheet, rotary=rotary),
        "family": [
            {
                "drive": drive.name,
                "law": drive.law,
                "parameters": _with_units(drive.parameters, rotary=rotary),
            }
            for drive in trial.drives
        ],
        "tracking_error": _rows(trial.table()),
    }


def _hold_document(hold: Hold) -> dict[str, Any]:
    """Return how a cascade holds its position."""
    return {
        "swing": {"value": _finite(hold.swing), "unit": hold.unit[1:]},
        "reversals": hold.reversals,
        "duration": {"value": hold.duration, "unit": "s"},
        "drive": hold.drive,
    }


def _feedforward_entry(learned: LearnedFromRecording) -> dict[str, Any]:
    """Return all compensators that were tried, and a feedforward that is not the law's."""
    compared = learned.trial.compared if learned.trial else None
    one, benefit = learned.feedforward, learned.benefit
    if compared is None or benefit is None:
        return {}
    found: dict[str, Any] = {
        "compensation": learned.choice,
        "compared": {
            "chosen": compared.chosen.name,
            "sentence": compared.sentence,
            "compensators": _rows(compared.table()),
        },
    }
    if one.model != "compensator":
        component = _component(one, rotary=learned.estimation.recording.rotary)
        found["feedforward"] = component | {"share": {"value": benefit.share, "unit": "1"}}
    return found


def _component(one: Compensator, *, rotary: bool) -> dict[str, Any]:
    """Return a compensator that is none of a law."""
    units = {known.name: known.unit or "1" for known in load_model(one.model).variables}
    given = {name: float(value) for name, value in dict(one.values).items()}
    return {"model": one.model, "parameters": _stated(given, units, rotary=rotary)}


def _observer_entry(learned: LearnedFromRecording) -> dict[str, Any]:
    """Return the disturbance observer and what each part adds, where one was tried."""
    observed = learned.trial.observed if learned.trial else None
    if observed is None:
        return {}
    entry: dict[str, Any] = {"refusal": learned.observer_refusal}
    if observed.designed is not None:
        designed = observed.designed
        rotary = learned.estimation.recording.rotary
        component = _component(designed.observer, rotary=rotary)
        if component["model"] == OBSERVER_MODEL:
            del component["model"]
        entry |= {
            **component,
            "peak_sensitivity": {"value": designed.sensitivity, "unit": "1"},
            "peak_sensitivity_without": {"value": designed.without, "unit": "1"},
        }
    rows = _rows(observed.summary())
    return {"compensation": learned.choice, "observer": entry, "error_ratio_of_parts": rows}


def _rows(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the rows of a table as plain data; a number that is not finite is None."""
    return [
        {str(key): _finite(x) if isinstance(x, float) else x for key, x in row.items()}
        for row in table.to_dict("records")
    ]


def _with_units(values: Mapping[str, float], *, rotary: bool) -> dict[str, dict[str, Any]]:
    """Return values of a law or of the drive FMU as plain data."""
    return {
        name: {"value": float(value), "unit": start_unit(name, rotary=rotary)}
        for name, value in values.items()
    }


def _tracking_document(tracking: Tracking) -> dict[str, Any]:
    errors = {name: dict(error.items()) for name, error in tracking.errors().items()}
    measured = tracking.measured and dict(tracking.measured.items())
    words = {"loop": tracking.loop, "command": tracking.command}
    return words | {"measured": measured, "simulated": errors}


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def versions() -> dict[str, str]:
    """Return the versions of the packages that the result depends on."""
    return installed_versions(PACKAGES)


def loop_document(loop: VelocityLoop) -> dict[str, dict[str, Any]]:
    """Return a velocity loop as plain data, for the entry ``loop``."""
    values = {name: getattr(loop.axis, name) for name in _AXIS}
    values |= {name: getattr(loop, name) for name in (*_LOOP, "m_ff")}
    if loop.K_x:
        values |= {name: getattr(loop, name) for name in _OUTER}
    if loop.velocity_filter is not None:
        values |= {name: getattr(loop.velocity_filter, name) for name in _GAINS}
    return _stated(values, LOOP_UNITS, rotary=loop.axis.rotary)


def validation_document(command: Trapezoid, *, rotary: bool = False) -> dict[str, Any]:
    """Return a validation command as plain data, for the entry ``validation``."""
    return _stated(dataclasses.asdict(command), TRAPEZOID, rotary=rotary)


def datasheet_document(sheet: Datasheet, *, rotary: bool = False) -> dict[str, Any]:
    """Return what is known of motor and encoder as plain data, for the entry ``datasheet``."""
    return _stated({name: getattr(sheet, name) for name in DATASHEET}, DATASHEET, rotary=rotary)


def _stated(
    values: Mapping[str, float], units: Mapping[str, str], *, rotary: bool
) -> dict[str, dict[str, Any]]:
    """Return values by name, each with its unit on this kind of drive."""
    return {
        name: {"value": value, "unit": motion_unit(units[name], rotary=rotary)}
        for name, value in values.items()
    }


def save_learned(path: Path | str, simulation: Simulation) -> Path:
    """Write what the compensators of a simulation have learned in its last run to a learned.json.

    Parameters
    ----------
    path : of the file, whose other entries are kept; it is made if it is absent
    simulation : with components that learn; all their parameters are written

    Raises
    ------
    UsageError
        When no component learns, or the file is not a learned.json.
    SimulationError
        When nothing was run.
    OSError
        When the file cannot be read or written.
    """
    path, components, learned = Path(path), {}, simulation.learned()
    for name, component in simulation.spec.system.components.items():
        if component.learned.variables:
            own = [v.name for v in component.variables.values() if v.causality == "parameter"]
            now = simulation.values([f"{name}.{parameter}" for parameter in own])
            values = {p: learned.get(f"{name}.{p}", x) for p, x in zip(own, now, strict=True)}
            components[name] = {"model": component.learned.model, "parameters": values}
    if not components:
        raise UsageError(f"{path}: no component of {simulation.spec.system.name} learns")
    document: dict[str, Any] = {"schema": SCHEMA}
    if path.exists():
        document = LearnedFile(path).document
    document = {**document, "components": components}
    return atomic_write(path, json.dumps(document, indent=2) + "\n")


def load_learned(path: Path | str) -> dict[str, float]:
    """Return what compensators have learned, from a learned.json or a winner.json of the arena.

    Returns
    -------
    ``component.parameter`` -> start value, for ``System.set`` and ``Simulation.run``

    Raises
    ------
    UsageError
        When the file is not valid, or a model has no such parameter.
    OSError
        When the file cannot be read.
    """
    return {
        f"{name}.{variable.name}": variable.start
        for name, model in LearnedFile(Path(path)).components.items()
        for variable in model.variables
        if variable.role == "parameter"
    }


class LearnedFile:
    """A learned.json, whose entries are checked when they are used, ``components`` at once.

    Attributes
    ----------
    document : its content
    components : compensators that learn while they run: model with its start values, by name

    Raises
    ------
    UsageError
        When the file, or the entry that is asked for, is not valid.
    OSError
        When the file cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            document = parse_json(read_limited(path, MOST_TEXT))
        except ValueError as error:
            raise UsageError(f"{path}: not a learned.json: {error}") from None
        self.document: dict[str, Any] = document if isinstance(document, dict) else {}
        schema = self.document.get("schema", 1)
        if type(schema) is not int or not 1 <= schema <= SCHEMA:
            raise UsageError(
                f"{path}: schema: expected a number from 1 to {SCHEMA}, got {schema!r:.80}; "
                "read it with the version of stickslip that wrote it, or learn again"
            )
        self.components = self._components()

    @cached_property
    def law(self) -> Law:
        """The friction law of the compensator; LuGre by default."""
        name = self.document.get("law", "lugre")
        try:
            return friction_law(str(name))
        except UnknownLaw as error:
            raise UsageError(f"{self.path}: law: {error}") from None

    @cached_property
    def friction(self) -> dict[str, float]:
        """The learned friction by name, in SI units, and what else of the law is in the file."""
        document, tuned = self.document, estimated(self.law)
        known = self._entry("parameters") or {}
        missing = [name for name in tuned if name not in known]
        if missing:
            raise UsageError(
                f"{self.path}: not a learned.json: {missing[0]} is missing; expected parameters "
                f"{', '.join(tuned)}, each with a value"
            )
        chosen = [name for name in self.law.parameters if name in document and name not in tuned]
        further = self._values("law", {name: document[name] for name in chosen})
        return {name: known[name] for name in tuned} | further

    @property
    def compensator(self) -> dict[str, float]:
        """The compensator's parameters, at the ``share`` of its force in the file.

        They are those of the friction unless the file has an entry for them.
        """
        whole = {**self.friction, **(self._entry("compensator") or {})}
        return self.law.share(whole, self._share(self.document))

    def _share(self, document: dict[str, Any]) -> float:
        share = self._values("share", {"share": document.get("share", {"value": 1.0})})["share"]
        if not 0.0 < share <= 1.0:
            raise UsageError(f"{self.path}: share: expected a value from 0 to 1; got {share:g}")
        return share

    @property
    def behind(self) -> list[Compensator]:
        """The components, to stand behind the compensator.

        Raises
        ------
        UsageError
            When one of them cannot.
        """
        found = []
        for name, model in self.components.items():
            if model.law is not None or name in ("compensator", *COMPONENTS):
                raise UsageError(
                    f"{self.path}: components: '{name}' cannot stand behind the compensator, for "
                    "it contains a friction law, or has the name of another part of the loop"
                )
            start = {v.name: v.start for v in model.variables if v.role == "parameter"}
            found.append(Compensator(name, model.name, start))
        return found

    @property
    def drives(self) -> tuple[Drive, ...]:
        """The drives on which the compensator is tried; by default those around the friction."""
        entries = self.document.get("family")
        if entries is None:
            given = (self.law, self.friction, self.validation, Known())
            return family(*given, rotary=self.rotary)
        try:
            return tuple(map(self._drive, entries))
        except (KeyError, TypeError, UnknownLaw) as error:
            raise UsageError(
                f"{self.path}: family: expected drives, each with drive, law and parameters; "
                f"got {error}"
            ) from None

    @property
    def feedforward(self) -> Compensator:
        """The feedforward that is exported: that of the law, or another one in the file."""
        entry = self.document.get("feedforward")
        if entry is None:
            return Compensator("compensator", "compensator", self.compensator)
        return self._component("feedforward", entry)

    @property
    def share(self) -> float:
        """The share of its whole force that the feedforward of the file has."""
        return self._share(self.document.get("feedforward", self.document))

    def at(self, share: float) -> Compensator:
        """Return the feedforward at a share of its whole force."""
        one = self.feedforward
        values = self.law.share(one.values, share / self.share)
        return dataclasses.replace(one, values=values)

    def _component(self, name: str, entry: Any, model: str = "") -> Compensator:
        """Return a compensator that is none of a law."""
        entry = entry if isinstance(entry, dict) else {}
        model = str(entry.get("model", model))
        values = self._values(name, entry.get("parameters"))
        component = "compensator" if name == "feedforward" else name
        try:
            one = Compensator(component, model, _with_switches(values, load_model(model)))
            missing = [key for key in one.ports.axis if key not in values]
        except ValueError as error:  # no model, or no compensator
            raise UsageError(f"{self.path}: {name}: {error}") from None
        if missing:
            raise UsageError(f"{self.path}: {name}: '{missing[0]}' is missing")
        return one

    @property
    def observer(self) -> Compensator:
        """The observer, for the axis and the sample period in the file.

        Raises
        ------
        UsageError
            When there is none, or its values are not valid.
        """
        entry = self.document.get("observer")
        entry = entry if isinstance(entry, dict) else {}
        if "parameters" not in entry:
            raise UsageError(
                f"{self.path}: contains no disturbance observer: "
                f"{entry.get('refusal') or 'learn from a log whose loop and mass are known'}"
            )
        return self._component("observer", entry, OBSERVER_MODEL)

    @property
    def observer_refusal(self) -> str:
        """Why the observer should not be exported; empty by default."""
        entry = self.document.get("observer")
        return str(entry.get("refusal") or "") if isinstance(entry, dict) else ""

    @property
    def standard_errors(self) -> dict[str, float]:
        """Standard errors of the friction by name in SI units, where the file has them."""
        return {k: v for k, v in self.drive_errors.items() if k in self.law.parameters}

    @property
    def drive_errors(self) -> dict[str, float]:
        """Standard errors of the friction, m and b by name in SI units, where the file has them."""
        names = (*self.friction, "m", "b")
        entries = {n: one for n, one in self.document["parameters"].items() if n in names}
        found = {name: entry.get("standard_error") for name, entry in entries.items()}
        return {
            name: float(value)
            for name, value in found.items()
            if isinstance(value, (int, float)) and math.isfinite(value) and value > 0.0
        }

    @property
    def drive(self) -> dict[str, float]:
        """The drive by name: its friction, m, b, the constant force F_0 and the delay.

        Mass and damping are those of the loop where they were not learned.
        """
        known = {**(self._entry("loop") or {}), **(self._entry("parameters") or {})}
        rest = {name: known.get(name, 0.0) for name in ("m", "b")}
        entries = {name: self.document.get(name, {"value": 0.0}) for name in ("F_0", "delay")}
        return {**self.friction, **rest, **self._values("F_0, delay", entries)}

    @property
    def feed(self) -> Feed:
        """The input of the compensator; the nominal loop by default."""
        feed = self.document.get("feed", "nominal")
        if feed not in FEEDS:
            raise UsageError(f"{self.path}: feed is {feed!r}; expected {' or '.join(FEEDS)}")
        return cast(Feed, feed)

    @property
    def rotary(self) -> bool:
        """Whether the drive is rotary."""
        return self.document.get("motion") == "rotary"

    @property
    def refusal(self) -> str:
        """Why the compensator should not be exported; empty by default."""
        return str(self.document.get("refusal") or "")

    @property
    def is_tried(self) -> bool:
        """Whether learning tried the compensator at the share of its force in the file."""
        return bool(self.document.get("tracking_error"))

    @property
    def loop(self) -> VelocityLoop | None:
        """The velocity loop; None in a file without it."""
        entry = self._entry("loop")
        if entry is None:
            return None
        try:
            with np.errstate(all="ignore"):
                return _loop_of(entry, rotary=self.rotary)
        except KeyError as error:
            raise UsageError(
                f"{self.path}: loop: {error} is missing; expected {', '.join((*_AXIS, *_LOOP))}"
            ) from None
        except (ValueError, ArithmeticError) as error:  # a ControlError is a ValueError
            raise UsageError(f"{self.path}: loop: {error}") from None

    def deployed(self, share: float) -> Compensator:
        """Return a share of the feedforward as a controller takes it; see ``servo.deployment``."""
        loop = self.loop if self.feed == "nominal" else None
        entry = self.document.get("T_s", {"value": loop.T_s if loop else LOOP.T_s})
        return deployed(self.at(share), loop, self._values("T_s", {"T_s": entry})["T_s"])

    @property
    def validation(self) -> Trapezoid:
        """The validation command; the paper's by default."""
        entry = self._entry("validation")
        if entry is None:
            return VALIDATION
        names = set(entry) == set(TRAPEZOID)
        if not names or not entry["height"] or not min(entry["plateau"], entry["begin"]) >= 0.0:
            raise UsageError(
                f"{self.path}: validation: expected {', '.join(TRAPEZOID)}, slope above 0, "
                f"height not 0, times of 0 or more; got {entry}"
            )
        try:
            return Trapezoid(**entry)
        except SignalError as error:
            raise UsageError(f"{self.path}: validation: {error}") from None

    @property
    def datasheet(self) -> Datasheet:
        """Motor and encoder; the paper's by default."""
        entry = self._entry("datasheet") or {}
        if not set(entry) <= set(DATASHEET) or not all(
            value > 0.0 or (name in ("tau_i", "encoder_noise") and value == 0.0)
            for name, value in entry.items()
        ):
            raise UsageError(
                f"{self.path}: datasheet: expected {', '.join(DATASHEET)}, each above 0; "
                f"got {entry}"
            )
        return Datasheet(**entry)

    def _components(self) -> dict[str, Model]:
        """Return the entry ``components``: a model with its start values, by name."""
        found = {}
        entries = self.document.get("components", {})
        try:
            for name, entry in entries.items():
                if not _NAME.fullmatch(name):
                    raise ValueError(f"expected a name of letters, digits and _, got {name!r:.80}")
                model = load_model(str(entry["model"]), entry.get("law"))
                if model.ports is None:
                    raise ValueError(f"{model.name} is not a compensator")
                values = {key: float(value) for key, value in entry["parameters"].items()}
                found[name] = model.with_start(values)
        except (*_UNFIT, StartValueError, UnknownModel, UnknownLaw) as error:
            raise UsageError(
                f"{self.path}: components: expected names, each with model and parameters; {error}"
            ) from None
        return found

    def _drive(self, entry: Mapping[str, Any]) -> Drive:
        """Return an entry of ``family``."""
        law = friction_law(str(entry["law"]))
        model = load_model("drive", law.name)
        values = _with_switches(self._values("family", entry["parameters"]), model)
        try:
            model.with_start(values)
        except StartValueError as error:
            raise UsageError(f"{self.path}: family: {error}") from None
        return Drive(str(entry["drive"]), law.name, values)

    def _entry(self, name: str) -> dict[str, float] | None:
        """Return the values of an entry, None if it is absent."""
        entry = self.document.get(name)
        return None if entry is None else self._values(name, entry)

    def _check_units(self, entry: str, stated: Mapping[str, Any]) -> None:
        """Raise where a value is not stated in the unit in which it is read."""
        units, old = dict(_UNITS.get(entry, {})), self.rotary and entry in _UNITS
        if entry == "parameters":
            known = (name for name in stated if name in self.law.parameters or name in _AXIS[:2])
            units = {name: unit_of(name) for name in known}
        for name, unit in stated.items():
            expected = motion_unit(units.get(name, unit), rotary=self.rotary)
            # What a rotary drive's loop is, was stated in the units of a linear one.
            if name in units and unit != expected and not (old and unit == units[name]):
                raise UsageError(
                    f"{self.path}: {entry}: {name} is in {unit!r:.40}; expected {expected}, in"
                    " which it is read"
                )

    def _values(self, name: str, entry: Any) -> dict[str, float]:
        """Return the finite values of an entry by name."""
        try:
            values = {key: float(item["value"]) for key, item in entry.items()}
            finite = all(map(math.isfinite, values.values()))
            stated = {key: unit for key, item in entry.items() if (unit := item.get("unit"))}
        except _UNFIT:
            finite = False
        if finite:
            self._check_units(name, stated)
            return values
        raise UsageError(
            f"{self.path}: {name}: expected names, each with a finite value and a unit; "
            f"got {entry!r:.80}"
        )


def _with_switches(values: Mapping[str, float], model: Model) -> dict[str, float | bool]:
    """Return values of a model with its switches as booleans."""
    switches = {one.name for one in model.variables if one.type == "boolean"}
    return {name: bool(value) if name in switches else value for name, value in values.items()}


def _loop_of(entry: Mapping[str, float], *, rotary: bool) -> VelocityLoop:
    axis = Axis(**{name: entry[name] for name in _AXIS}, rotary=rotary)
    velocity_filter = None
    if "L_x" in entry:
        gains = {name: entry[name] for name in _GAINS}
        velocity_filter = VelocityFilter(axis, entry["T_s"], **gains)
    return close_velocity_loop(
        axis,
        **{name: entry[name] for name in _LOOP},
        m_ff=entry.get("m_ff", 0.0),
        velocity_filter=velocity_filter,
        **{name: entry[name] for name in _OUTER if name in entry},
    )
