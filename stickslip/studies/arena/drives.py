"""The drives of the arena: a law, true parameters, a loop. What tunes does not see them."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from stickslip import models
from stickslip.compensators.entrants import SPEED
from stickslip.errors import UsageError
from stickslip.learned.file import LearnedFile
from stickslip.servo.axis import LOOP, Axis, ControlError, Datasheet
from stickslip.servo.velocity_loop import VelocityLoop, close_velocity_loop, design_velocity_loop
from stickslip.studies.arena.drive_names import content, drive_names
from stickslip.toml_files import read_toml
from stickslip.trial.family import axis_values

AXIS = Axis(5.557, 6.6135, Datasheet().tau_i)  # That of the paper's stage
QUIET = 0.25  # Noise of the encoder of a learned drive, relative to its step
SHARES = {"friction": (0.5, 0.8, 1.2, 1.5), "mass": (0.5, 0.8, 1.25, 2.0), "lag": (5.0,)}
"""Factors on what a drive has in robustness runs."""
STEPS = {"encoder step x 0.25": 0.25, "encoder step x 5": 5.0}  # Factors on the step of the encoder
NOISE = 3.0  # Factor on the noise
Changes = Mapping[str, tuple[str, Mapping[str, float]]]
"""What is changed -> command, and start values of the drive FMU."""
_KEYS = {"title", "law", "parameters", "loop", "nominal", "axis", "speed"}


@dataclass(frozen=True)
class Drive:
    """A drive."""

    # short name, and display name
    name: str
    title: str
    law: str  # name of its friction law
    # start values of the drive FMU, its truth
    parameters: Mapping[str, float] = field(default_factory=dict)
    # K_p [N s/m] and K_i [N/m] of its controller; those of the paper's loop where empty
    gains: Mapping[str, float] = field(default_factory=dict)
    nominal: bool = False  # whether what is tuned on it is carried over to the others
    # for which its loop is designed, and the sampling of the loop
    axis: Axis = AXIS
    T_s: float = LOOP.T_s
    tau_f: float = LOOP.tau_f
    sheet: Datasheet = field(default_factory=Datasheet)  # what is known of motor and encoder
    speed: float = SPEED  # of the fastest commands [m/s]

    @property
    def loop(self) -> VelocityLoop:
        """The velocity loop, for the axis that the controller's design assumes."""
        if not self.gains:
            return design_velocity_loop(self.axis, LOOP)
        gains = self.gains["K_p"], self.gains["K_i"]
        return close_velocity_loop(self.axis, self.T_s, self.tau_f, *gains)

    def changes(self, robustness: str, resolution: str) -> Changes:
        """Return changed drives (mechanics; encoder and noise), and this one, by commands."""
        law, model = models.load_law(self.law), models.load_model("drive", self.law)
        true = {**{v.name: v.start for v in model.variables}, **self.parameters}
        stems = {name: name.partition("[")[0] for name in true}
        powers = {n: law.parameters[s].force for n, s in stems.items() if s in law.parameters}
        # label, command, powers of the factor by parameter, and the factor
        changes: list[tuple[str, str, Mapping[str, float], float]] = [
            (f"{what} x {factor:g}", robustness, names, factor)
            for what, names in {"friction": powers, "mass": {"m": 1}, "lag": {"tau_i": 1}}.items()
            for factor in SHARES[what]
        ]
        steps = {"encoder_step": 1}
        changes += [(label, resolution, steps, factor) for label, factor in STEPS.items()]
        changes.append((f"noise x {NOISE:g}", resolution, {"noise_x": 1, "noise_F": 1}, NOISE))
        plain = {command: (command, dict[str, float]()) for command in (robustness, resolution)}
        return plain | {
            label: (command, {n: true[n] * factor**power for n, power in of.items() if power})
            for label, command, of, factor in changes
        }

    @property
    def mass(self) -> float:
        """The true mass [kg]."""
        return float(self.parameters.get("m", AXIS.m))


def default_drives(laws: Sequence[str] | None = None) -> list[Drive]:
    """Return the drives of ``drives.toml``, and one of each law that none has; of some laws."""
    found, common = _drives("drives.toml", content())
    for law in drive_names()[len(found) :]:  # those of laws without one
        found.append(Drive(law, models.load_law(law).title, law, common))
    return _of_laws(found, laws)


def read_drives(
    source: Path | Mapping[str, Mapping[str, Any]], laws: Sequence[str] | None = None
) -> list[Drive]:
    """Return the drives of a TOML file like ``drives.toml``, or of its content; or raise."""
    if isinstance(source, Path):
        return _of_laws(_drives(str(source), read_toml(source))[0], laws)
    return _of_laws(_drives("drives", dict(source))[0], laws)


def learned_drive(path: Path) -> Drive:
    """Return the drive of a learned.json, in its loop."""
    learned = LearnedFile(path)
    loop, sheet = learned.loop, learned.datasheet
    if loop is None:
        raise UsageError(f"{path}: contains no loop, in which compensators could be compared")
    of_drive = {v.name for v in models.load_model("drive", learned.law.name).variables} - {"F_0"}
    parameters = {
        **{name: value for name, value in learned.drive.items() if name in of_drive},
        **axis_values(loop, sheet),
        "noise": True,
        "noise_x": QUIET * sheet.encoder_step,
        "noise_F": sheet.force_noise,
    }
    true = {name: learned.drive[name] for name in ("m", "b") if learned.drive[name] > 0.0}
    name = path.stem if path.stem != "learned" else path.resolve().parent.name
    return Drive(
        re.sub(r"[^\w-]", "_", name) or "learned",
        f"{learned.law.title}, learned",
        learned.law.name,
        {name: float(value) for name, value in {**parameters, **true}.items()},
        {"K_p": loop.K_p, "K_i": loop.K_i},
        False,
        loop.axis,
        loop.T_s,
        loop.tau_f,
        sheet,
        abs(learned.validation.height),
    )


def _of_laws(drives: list[Drive], laws: Sequence[str] | None) -> list[Drive]:
    for name in laws or ():
        models.load_law(name)
    found = [drive for drive in drives if not laws or drive.law in laws]
    if not found:
        raise UsageError(f"no drive has one of the laws {', '.join(laws or ())}")
    return found


def _drives(where: str, content: dict[str, Any]) -> tuple[list[Drive], dict[str, float]]:
    common = content.pop("measurement", {})
    found = []
    for name, table in content.items():
        if not isinstance(table, dict) or not {"law"} <= table.keys() <= _KEYS:
            raise UsageError(
                f"{where}: drive '{name}': expected a table with law and, if needed,"
                f" {', '.join(sorted(_KEYS - {'law'}))}"
            )
        try:
            found.append(_drive(name, table, common))
        except (UsageError, ControlError, models.ModelError) as error:
            raise UsageError(f"{where}: drive '{name}': {error}") from None
    if not found:
        raise UsageError(f"{where}: expected a table for each drive, got none")
    return found, common


def _drive(name: str, table: Mapping[str, Any], common: Any) -> Drive:
    """Return the drive of a table; ``common`` are parameters of all drives."""
    if not name.replace("_", "").replace("-", "").isalnum():
        raise UsageError("expected a name of letters, digits, '_' and '-'")
    law, title, nominal = table["law"], table.get("title", name), table.get("nominal", False)
    if not (isinstance(law, str) and isinstance(title, str) and isinstance(nominal, bool)):
        raise UsageError("expected text as law and title, true or false as nominal")
    parameters = {
        **_numbers("measurement", common),
        **_numbers("parameters", table.get("parameters", {})),
    }
    model = models.load_model("drive", law).with_start(parameters)
    true = {v.name: v.start for v in model.variables if v.role == "parameter"}
    for force in ("F_s", "F_c"):
        if true.get(force, 0.0) >= true["u_max"]:
            raise UsageError(
                f"its {force} of {true[force]:g} N is not below the force limit u_max of"
                f" {true['u_max']:g} N"
            )
    loop, speed = _numbers("loop", table.get("loop", {})), table.get("speed", SPEED)
    if loop and set(loop) != {"K_p", "K_i"}:
        raise UsageError("loop: expected K_p and K_i")
    own = {"m": true["m"], "b": true["b"], "tau_i": true["tau_i"] * bool(true["current_loop"])}
    assumed = _numbers("axis", table.get("axis", {}))
    if unknown := sorted(assumed.keys() - own.keys()):
        raise UsageError(f"axis: '{unknown[0]}' is unknown; expected {', '.join(own)}")
    if type(speed) not in (int, float) or not 0.0 < speed < np.inf:
        raise UsageError(f"speed: expected a number above 0, got {speed!r}")
    m, b, tau_i = {**own, **assumed}.values()
    axis = Axis(m, b, tau_i)
    sheet = Datasheet(axis.m, true["u_max"], axis.tau_i, true["encoder_step"], true["noise_F"])
    drive = Drive(
        name, title, law, parameters, loop, nominal, axis, sheet=sheet, speed=float(speed)
    )
    _ = drive.loop  # raises where it is unstable
    return drive


def _numbers(key: str, found: Any) -> dict[str, float]:
    """Return a table of numbers from a file."""
    if not isinstance(found, dict) or not all(isinstance(x, int | float) for x in found.values()):
        raise UsageError(f"{key}: expected a table of numbers")
    return found
