"""Entries of learned.json that several studies write, and the keys and units that are read."""

import dataclasses
from functools import partial
from typing import Any

from stickslip.cosim import Trapezoid
from stickslip.models import Law, load_model
from stickslip.models.export.units import motion_unit
from stickslip.servo.axis import Datasheet
from stickslip.servo.systems import Compensator
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.storage.codec import state, units
from stickslip.versions import installed_versions

SCHEMA = 2  # Version of the keys that this module writes, and the latest that it reads
OBSERVER_MODEL = "dob"  # Model of an observer without an entry for it
POSITION_FORCE = "position_force"  # Key of the force of position, and the model that gives it
PACKAGES = ("stickslip", "control", "fmpy", "numpy", "scipy", "ziglang")
LOOP_UNITS = {
    "m": "kg", "b": "N.s/m", "tau_i": "s", "T_s": "s", "tau_f": "s", "K_p": "N.s/m",
    "K_i": "N/m", "m_ff": "kg", "K_x": "1/s", "velocity_feedforward": "1", "L_x": "1",
    "L_v": "1/s", "L_d": "N/m",
}  # fmt: skip
DATASHEET = units(Datasheet)
TRAPEZOID = {"height": "m/s", "slope": "m/s2", "plateau": "s", "begin": "s"}
FILTER_KEYS = ("L_x", "L_v", "L_d")
AXIS_KEYS = ("m", "b", "tau_i")
LOOP_KEYS = ("T_s", "tau_f", "K_p", "K_i")
OUTER_KEYS = ("K_x", "velocity_feedforward")


def versions() -> dict[str, str]:
    """Return the versions of the packages that the result depends on."""
    return installed_versions(PACKAGES)


def loop_document(loop: VelocityLoop) -> dict[str, dict[str, Any]]:
    """Return a velocity loop as plain data, for the entry ``loop``."""
    values = {name: getattr(loop.axis, name) for name in AXIS_KEYS}
    values |= {name: getattr(loop, name) for name in (*LOOP_KEYS, "m_ff")}
    if loop.K_x:
        values |= {name: getattr(loop, name) for name in OUTER_KEYS}
    if loop.velocity_filter is not None:
        values |= {name: getattr(loop.velocity_filter, name) for name in FILTER_KEYS}
    return state(values, LOOP_UNITS, partial(motion_unit, rotary=loop.axis.rotary))


def validation_document(command: Trapezoid, *, rotary: bool = False) -> dict[str, Any]:
    """Return a validation command as plain data, for the entry ``validation``."""
    of_drive = partial(motion_unit, rotary=rotary)
    return state(dataclasses.asdict(command), TRAPEZOID, of_drive)


def component_entry(one: Compensator, *, rotary: bool) -> dict[str, Any]:
    """Return a compensator beside that of the learned law, as learned.json has it."""
    model = load_model(one.model, one.law or None)
    own_units = {known.name: known.unit or "1" for known in model.variables}
    given = {name: float(value) for name, value in dict(one.values).items()}
    stated = state(given, own_units, partial(motion_unit, rotary=rotary))
    law = {"law": one.law} if one.law else {}
    return {"model": one.model, **law, "parameters": stated}


def law_entry(law: Law) -> dict[str, str]:
    """Return the name of the compensator's friction law; a file without it has LuGre's."""
    return {} if law.name == "lugre" else {"law": law.name}
