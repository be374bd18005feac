"""Drives of every friction law, with what disturbs them."""

from dataclasses import dataclass, field

import numpy as np

import stickslip as ss
from stickslip.rigs.contract import COMMISSIONING
from stickslip.servo.axis import Datasheet
from stickslip.servo.velocity_loop import VelocityLoop, design_velocity_loop

LEVELS = ("F_c", "F_s")


@dataclass(frozen=True)
class Drive:
    """A drive by its friction law and the parameters of its FMU that are not Table 2's."""

    law: str = "lugre"
    parameters: dict[str, float | bool] = field(default_factory=dict)

    @property
    def start(self) -> dict[str, float]:
        """All its parameters by name."""
        model = ss.models.load_model("drive", self.law)
        return {variable.name: variable.start for variable in model.variables} | self.parameters

    @property
    def mass(self) -> float:
        """Moving mass [kg]."""
        return float(self.start["m"])

    @property
    def loop(self) -> VelocityLoop:
        """The loop in which it is recorded, and in which compensators are tried."""
        return design_velocity_loop(Datasheet().axis(self.mass, 0.0), COMMISSIONING)

    def at(self, level: float) -> dict[str, float]:
        """Return its levels of friction times a factor, for a run of its loop."""
        return {f"drive.{name}": level * self.start[name] for name in LEVELS if name in self.start}

    def friction(self, v: np.ndarray) -> np.ndarray:
        """Return friction at speeds v > 0 [N], the mean over directions and positions."""
        return steady(self.start, v)


def steady(values: dict[str, float], v: np.ndarray) -> np.ndarray:
    """Return friction at constant speeds v > 0 [N] by the parameters of any law."""
    force = values["F_c"] + values["b"] * v
    if "F_s" in values:
        rise = values["F_s"] - values["F_c"]
        force = force + rise * np.exp(-((v / values["v_s"]) ** values["delta"]))
    return force


DRIVES = {
    "Table 2": Drive(),
    "light": Drive(parameters={"m": 0.8, "F_c": 1.5, "F_s": 2.4, "v_s": 2e-3, "sigma_0": 1e5}),
    "heavy": Drive(parameters={"m": 14.0, "F_c": 14.0, "F_s": 20.0, "sigma_0": 8e5}),
    "flat": Drive(parameters={"F_s": 6.2, "F_c": 6.0, "v_s": 1e-3}),
    "dahl": Drive("dahl"),
    "gms": Drive("gms"),
    "coulomb_stribeck": Drive("coulomb_stribeck"),
    "along the guide": Drive(parameters={"position_dependent": True, "position_amplitude": 0.08}),
    "asymmetric": Drive(parameters={"asymmetric": True, "asymmetry": 0.08}),
    "coarse encoder": Drive(parameters={"encoder_step": 2e-6}),
    "slow current": Drive(parameters={"tau_i": 5e-4}),
    "ripple": Drive(parameters={"ripple": True, "ripple_amplitude": 0.3}),
}
