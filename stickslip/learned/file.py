"""learned.json: its keys, and the one module that reads it.

    "parameters": {"F_s": {"value": 8.98, "unit": "N", "low": 8.89, "high": 9.08, ...}, ...}
    "loop": {"K_p": {"value": 4717.4, "unit": "N.s/m"}, ...}     absent in older files
    "validation": {"height": {"value": 0.04, "unit": "m/s"}, ...}
    "datasheet": {"encoder_step": {"value": 4e-7, "unit": "m"}, ...}

Values are in SI units. The loop has m b tau_i T_s tau_f K_p K_i, and where they are used m_ff,
the gains L_x L_v L_d of a velocity filter, and K_x velocity_feedforward of a cascade. ``law`` names
the friction law where it is not LuGre.
Only ``parameters`` is needed to read a file. ``schema`` counts changes of keys: 1, that of files
without it, has ``judge`` and ``visible`` where 2 has ``criterion`` and ``identifiability``.
"""

import dataclasses
import math
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.catalog.parameters import estimated, friction_law, unit_of
from stickslip.cosim import SignalError, Trapezoid
from stickslip.errors import UsageError
from stickslip.evaluation.motions import VALIDATION
from stickslip.fmi.files import MOST_TEXT, parse_json, read_limited
from stickslip.identification.sliding.position_force import block_parameters, with_known_force
from stickslip.learned.writing import (
    AXIS_KEYS,
    DATASHEET,
    FILTER_KEYS,
    LOOP_KEYS,
    LOOP_UNITS,
    OBSERVER_MODEL,
    OUTER_KEYS,
    POSITION_FORCE,
    SCHEMA,
    TRAPEZOID,
)
from stickslip.logs import Recording
from stickslip.models import Law, Model, StartValueError, UnknownLaw, load_model
from stickslip.models.export.units import motion_unit
from stickslip.servo.axis import LOOP, Axis, Datasheet
from stickslip.servo.systems import Compensator, deployed
from stickslip.servo.velocity_filter import VelocityFilter
from stickslip.servo.velocity_loop import VelocityLoop, close_velocity_loop
from stickslip.trial.benefit import Bench, bench_of
from stickslip.trial.family import Drive, Evidence, family

_UNITS = {"loop": LOOP_UNITS, "validation": TRAPEZOID, "datasheet": DATASHEET}
_UNFIT = (AttributeError, KeyError, TypeError, ValueError, OverflowError)
"""What an entry of the wrong shape raises."""
NORMAL = 1.96  # half-width of a 95 % interval over a standard error, where a file has no interval


class LearnedFile:
    """A learned.json, whose entries are checked when they are used; ``document`` is its content.

    Raises UsageError when the file, or the entry that is asked for, is not valid, or OSError when
    the file cannot be read.
    """

    def __init__(self, path: Path) -> None:
        if path.is_dir():  # of learn or tune
            named = ("tuned.json", "learned.json")
            path = next((path / one for one in named if (path / one).exists()), path / named[-1])
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

    def mapping(self, name: str) -> dict[str, Any]:
        """Return an entry with entries of its own; empty where there is no such one."""
        entry = self.document.get(name)
        return entry if isinstance(entry, dict) else {}

    @cached_property
    def law(self) -> Law:
        """The friction law of the compensator; LuGre by default."""
        with self._named("law", UnknownLaw):
            return friction_law(str(self.document.get("law", "lugre")))

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
        """The parameters of the compensator at its share; else those of the friction."""
        whole = {**self.friction, **(self._entry("compensator") or {})}
        return self.law.share(whole, self._share(self.document))

    def _share(self, document: dict[str, Any]) -> float:
        share = self._values("share", {"share": document.get("share", {"value": 1.0})})["share"]
        if not 0.0 < share <= 1.0:
            raise UsageError(f"{self.path}: share: expected a value from 0 to 1; got {share:g}")
        return share

    @property
    def drives(self) -> tuple[Drive, ...]:
        """The drives on which the compensator is tried; by default those around the friction."""
        entries = self.document.get("family")
        if entries is None:
            return family(self.law, self.friction, self.validation, Evidence())
        try:
            return tuple(map(self._drive, entries))
        except (KeyError, TypeError, UnknownLaw) as error:
            raise UsageError(
                f"{self.path}: family: expected drives, each with drive, law and parameters; "
                f"got {error}"
            ) from None

    def bench(
        self, loop: VelocityLoop, datasheet: Datasheet | None = None, workers: int = 1
    ) -> AbstractContextManager[Bench]:
        """Return the drives of the file in a loop, by default with the data sheet of the file."""
        sheet, command = datasheet or self.datasheet, self.validation
        further: dict[str, Any] = {"command": command, "datasheet": sheet}
        return bench_of(self.law, loop, self.friction, self.drives, workers=workers, **further)

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
        law = friction_law(one.law) if one.law else self.law
        return dataclasses.replace(one, values=law.share(one.values, share / self.share))

    def _component(self, name: str, entry: Any, model: str = "") -> Compensator:
        """Return a compensator beside that of the learned law, as learned.json has it."""
        entry = entry if isinstance(entry, dict) else {}
        model, law = str(entry.get("model", model)), str(entry.get("law", ""))
        values = self._values(name, entry.get("parameters"))
        component = "compensator" if name == "feedforward" else name
        with self._named(name, ValueError, UnknownLaw):  # no model, or no compensator
            known = load_model(model, law or None)
            file = f"{model}_{law}" if law else ""
            one = Compensator(component, model, _with_switches(values, known), file, law=law)
            missing = [key for key in one.ports.axis if key not in values and not law]
        if missing:
            raise UsageError(f"{self.path}: {name}: '{missing[0]}' is missing")
        return one

    @property
    def observer(self) -> Compensator:
        """The observer for the axis in the file; raises UsageError without a valid one."""
        entry = self.mapping("observer")
        if "parameters" not in entry:
            raise UsageError(
                f"{self.path}: contains no disturbance observer: "
                f"{entry.get('refusal') or 'learn from a log whose loop and mass are known'}"
            )
        return self._component("observer", entry, OBSERVER_MODEL)

    @property
    def position_force(self) -> Compensator | None:
        """The block that holds gravity and cogging; None where there are none."""
        entry = self._entry(POSITION_FORCE)
        if entry is None:
            return None
        values = block_parameters(entry)
        with self._named(POSITION_FORCE, StartValueError):
            load_model(POSITION_FORCE).with_start(values)
        return Compensator(POSITION_FORCE, POSITION_FORCE, values)

    def with_position_force(self, recording: Recording) -> Recording:
        """Return a recording of the drive, with what it holds by its position."""
        if (held := self.position_force) is None:
            return recording
        entry = self.document.get("delay", {"value": 0.0})
        delay = self._values("delay", {"delay": entry})["delay"]
        return with_known_force(recording, held.values, delay)

    @property
    def observer_refusal(self) -> str:
        """Why the observer should not be exported; empty by default."""
        return str(self.mapping("observer").get("refusal") or "")

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
        """The drive by name: its friction, m and b, learned or of the loop, F_0 and the delay."""
        known = {**(self._entry("loop") or {}), **(self._entry("parameters") or {})}
        rest = {name: known.get(name, 0.0) for name in ("m", "b")}
        entries = {name: self.document.get(name, {"value": 0.0}) for name in ("F_0", "delay")}
        return {**self.friction, **rest, **self._values("F_0, delay", entries)}

    @property
    def rotary(self) -> bool:
        """Whether the drive is rotary."""
        return self.document.get("motion") == "rotary"

    @property
    def refusal(self) -> str:
        """Why the compensator should not be exported; empty by default."""
        return str(self.document.get("refusal") or "")

    @property
    def written(self) -> tuple[str, ...]:
        """Names of the FMUs that learning wrote; that of the feedforward where it is not known."""
        files = self.mapping("written").get("files")
        return tuple(map(str, files)) if isinstance(files, list) else ("compensator.fmu",)

    @property
    def loop(self) -> VelocityLoop | None:
        """The velocity loop; None in a file without it."""
        entry = self._entry("loop")
        if entry is None:
            return None
        needed = (*AXIS_KEYS, *LOOP_KEYS, *(FILTER_KEYS if "L_x" in entry else ()))
        if missing := [name for name in needed if name not in entry]:
            raise UsageError(
                f"{self.path}: loop: {missing[0]!r} is missing; expected {', '.join(needed)}"
            )
        # A ControlError is a ValueError.
        with self._named("loop", ValueError, ArithmeticError), np.errstate(all="ignore"):
            return _loop_of(entry, rotary=self.rotary)

    def deployed(self, share: float) -> Compensator:
        """Return a share of the feedforward as a controller takes it; see ``servo.systems``."""
        loop = self.loop
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
        with self._named("validation", SignalError):
            return Trapezoid(**entry)

    @property
    def datasheet(self) -> Datasheet:
        """Motor and encoder; the paper's by default."""
        entry = self._entry("datasheet")
        if entry is None:
            return Datasheet()
        if not set(entry) <= set(DATASHEET) or not all(
            value > 0.0 or (value == 0.0 and name in ("tau_i", "encoder_noise", "force_noise"))
            for name, value in entry.items()
        ):
            raise UsageError(
                f"{self.path}: datasheet: expected {', '.join(DATASHEET)}, each above 0; "
                f"got {entry}"
            )
        return Datasheet(**{"force_noise": 0.0, **entry})

    def _drive(self, entry: Mapping[str, Any]) -> Drive:
        """Return an entry of ``family``."""
        law = friction_law(str(entry["law"]))
        model = load_model("drive", law.name)
        values = _with_switches(self._values("family", entry["parameters"]), model)
        with self._named("family", StartValueError):
            model.with_start(values)
        level, decides = float(entry.get("level", 1.0)), bool(entry.get("decides", True))
        return Drive(str(entry["drive"]), law.name, values, level, decides=decides)

    @contextmanager
    def _named(self, entry: str, *faults: type[Exception]) -> Iterator[None]:
        """Name the file and the entry in errors."""
        try:
            yield
        except faults as error:
            raise UsageError(f"{self.path}: {entry}: {error}") from None

    def _entry(self, name: str) -> dict[str, float] | None:
        """Return the values of an entry, None if it is absent."""
        entry = self.document.get(name)
        return None if entry is None else self._values(name, entry)

    def _check_units(self, entry: str, stated: Mapping[str, Any]) -> None:
        """Raise where a value is not stated in the unit in which it is read."""
        units, old = dict(_UNITS.get(entry, {})), self.rotary and entry in _UNITS
        if entry == POSITION_FORCE:
            units = {one.name: one.unit or "1" for one in load_model(entry).variables}
        if entry == "parameters":
            known = (
                name for name in stated if name in self.law.parameters or name in AXIS_KEYS[:2]
            )
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
    """Return values of a model with its switches as booleans and its counts as integers."""
    kinds = {one.name: {"boolean": bool, "integer": int}.get(one.type) for one in model.variables}
    return {name: kind(x) if (kind := kinds.get(name)) else x for name, x in values.items()}


def _loop_of(entry: Mapping[str, float], *, rotary: bool) -> VelocityLoop:
    axis = Axis(**{name: entry[name] for name in AXIS_KEYS}, rotary=rotary)
    velocity_filter = None
    if "L_x" in entry:
        gains = {name: entry[name] for name in FILTER_KEYS}
        velocity_filter = VelocityFilter(axis, entry["T_s"], **gains)
    return close_velocity_loop(
        axis,
        **{name: entry[name] for name in LOOP_KEYS},
        m_ff=entry.get("m_ff", 0.0),
        velocity_filter=velocity_filter,
        **{name: entry[name] for name in OUTER_KEYS if name in entry},
    )
