"""Drives of every friction law with random parameters and imperfections, and what is true of them.

What an interval should hold is defined as follows. *F(v)* is the friction at a steady speed,
viscous friction with it: of a drive whose friction differs between the directions the mean of both
magnitudes, and of one whose friction varies along the guide the mean over the travel that was
recorded, each place of it counted alike; LuGre's F_s and F_c are means in the same way. *b* is the
drive's viscous friction, that is the slope of F(v) far above the Stribeck velocity, whatever the
law. The *offset* is the constant force against the motor, with the mean of the ripple over the
travel and half the difference between the friction forward and backward, at Coulomb friction.
"""

from dataclasses import dataclass, field

import numpy as np

from stickslip import models
from stickslip.fmi.process import temporary_folder
from stickslip.logs import Recording
from stickslip.planning import Limits, plan
from stickslip.rigs.contract import COMMISSIONING
from stickslip.servo.axis import Datasheet
from stickslip.servo.measurement import level
from stickslip.servo.systems import servo_loop
from stickslip.servo.velocity_loop import close_velocity_loop, design_velocity_loop
from stickslip.studies.learn.recorded import gains_of

LAWS = ("lugre", "dahl", "gms", "coulomb_stribeck")
MASS = (0.8, 14.0)  # [kg]
F_C = (1.5, 14.0)  # [N]
RISE = (1.0, 3.0)  # F_s / F_c
V_S = (3e-4, 3e-3)  # [m/s]
VISCOUS = (2.0, 30.0)  # [N s/m]
SIGMA_0 = (1e5, 1e6)  # [N/m]
DAMPING = (0.3, 2.0)  # sigma_1 / (2 sqrt(sigma_0 m))
K_X = (15.0, 60.0)  # [1/s]
FLAGS = ("asymmetric", "position_dependent", "ripple", "noise")
SHARE = 0.3
"""Probability of each imperfection."""


@dataclass(frozen=True)
class RandomDrive:
    """A drive, and how it is recorded.

    Attributes
    ----------
    law : its friction law
    parameters : of the drive FMU by name [SI]
    imperfections : names of those that are on
    constant : force against the motor [N]
    speed, stroke : limits of the experiment [m/s], [m]
    nominal_mass : for which the loop is designed [kg]
    gains : factor of the controller gains that learning is told; 1 where they are right, 0 where
        it is told none
    K_x, velocity_feedforward : of the position loop around the velocity loop; 0: none [1/s], [1]
    """

    law: str = "lugre"
    parameters: dict[str, float] = field(default_factory=dict)
    imperfections: tuple[str, ...] = ()
    constant: float = 0.0
    speed: float = 0.04
    stroke: float = 0.1
    nominal_mass: float = 5.5
    gains: float = 1.0
    K_x: float = 0.0
    velocity_feedforward: float = 1.0

    def along(self, travel: np.ndarray) -> dict[str, float]:
        """Return the parameters, those of friction as means over the travel (n,) [m]."""
        share = self._share(travel)
        own = self.parameters
        return {n: one * share if n in ("F_c", "F_s") else one for n, one in own.items()}

    def offset(self, travel: np.ndarray) -> float:
        """Return the mean of the forces that move the drive forward and backward [N]."""
        p, x = self.parameters, _even(travel)
        ripple = 0.0
        if "ripple" in self.imperfections:
            wave = np.sin(2.0 * np.pi * x / p["ripple_period"])
            ripple = float(np.mean(p["ripple_amplitude"] * wave))
        asymmetry = p.get("asymmetry", 0.0) * self._share(travel) * p["F_c"]
        return self.constant + asymmetry - ripple

    def friction(self, v: float, travel: np.ndarray) -> float:
        """Return F(v) [N] at a speed above 0 [m/s]."""
        p = self.parameters
        return float(level(p, v)) * self._share(travel) + p["b"] * v

    def _share(self, travel: np.ndarray) -> float:
        """Return the mean of what varies along the guide."""
        if "position" not in self.imperfections:
            return 1.0
        p = self.parameters
        wave = np.sin(2.0 * np.pi * _even(travel) / p["position_period"])
        return 1.0 + float(np.mean(p["position_amplitude"] * wave))


def _even(travel: np.ndarray) -> np.ndarray:
    return np.linspace(travel.min(), travel.max(), 2001)


def random_drive(seed: int, *, cascade: bool = False, sound: bool = False) -> RandomDrive:
    """Return a drive of a random law with random imperfections.

    Parameters
    ----------
    cascade : whether a position loop is around its velocity loop
    sound : whether it has no imperfections, and learning is told the right gains
    """
    rng = np.random.default_rng([seed, 66])

    def log(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    law = LAWS[seed % len(LAWS)]
    m, F_c, sigma_0 = log(*MASS), log(*F_C), log(*SIGMA_0)
    choices = {
        "m": m,
        "b": log(*VISCOUS),
        "F_c": F_c,
        "F_s": F_c * rng.uniform(*RISE),
        "v_s": log(*V_S),
        "delta": float(rng.choice([1.0, 2.0])),
        "sigma_0": sigma_0,
        "sigma_1": 2.0 * np.sqrt(sigma_0 * m) * rng.uniform(*DAMPING),
        "C": log(300.0, 3000.0),
    }
    own = {*models.load_law(law).parameters, "m", "b"}
    parameters = {name: float(value) for name, value in choices.items() if name in own}
    noise = {"noise": 1.0, "noise_x": log(3e-8, 3e-7), "noise_F": log(0.02, 0.1)}
    further = {
        "asymmetry": {"asymmetric": 1.0, "asymmetry": rng.uniform(-0.15, 0.15)},
        "position": {
            "position_dependent": 1.0,
            "position_amplitude": rng.uniform(0.02, 0.12),
            "position_period": log(5e-3, 6e-2),
        },
        "ripple": {
            "ripple": 1.0,
            "ripple_amplitude": F_c * rng.uniform(0.02, 0.1),
            "ripple_period": log(1e-2, 4e-2),
        },
        "encoder": {"encoder_step": log(1e-6, 2e-6)},
        "lag": {"tau_i": log(2e-4, 8e-4)},
        "saturation": {"u_max": choices["F_s"] * 1.3 + 2.0 * m * rng.uniform(0.4, 0.8)},
    }
    on = tuple(name for name in further if rng.random() < SHARE and not sound)
    for name in on:
        parameters |= {key: float(value) for key, value in further[name].items()}
    told = 0.0 if sound else rng.random()
    constant = float(rng.uniform(-0.3, 0.3) * F_c) if rng.random() < SHARE else 0.0
    speed, stroke, nominal_mass = log(0.02, 0.1), log(0.05, 0.2), m * log(0.7, 1.4)
    gains = 1.0 if told < 0.5 else 0.0 if told < 0.75 else float(rng.choice([0.5, 0.95, 1.5]))
    return RandomDrive(
        law=law,
        parameters=parameters | noise,
        imperfections=on,
        constant=constant,
        speed=speed,
        stroke=stroke,
        nominal_mass=nominal_mass,
        gains=gains,
        K_x=log(*K_X) if cascade else 0.0,
        velocity_feedforward=float(rng.choice([0.0, 0.5, 1.0])) if cascade else 1.0,
    )


def record(drive: RandomDrive, seed: int) -> tuple[Recording, dict[str, float] | None]:
    """Simulate the planned experiment; return its recording and the gains that are told."""
    axis = Datasheet().axis(drive.nominal_mass, 0.0)
    loop = design_velocity_loop(axis, COMMISSIONING)
    if drive.K_x:
        position = {"K_x": drive.K_x, "velocity_feedforward": drive.velocity_feedforward}
        loop = close_velocity_loop(axis, loop.T_s, loop.tau_f, loop.K_p, loop.K_i, **position)
    v_cmd = plan(Limits(stroke=drive.stroke, speed=drive.speed))["velocity_command"].to_numpy()
    measured = ("drive.x_enc", "drive.F_m")
    stop = (len(v_cmd) - 1) * loop.T_s
    p = drive.parameters
    start = {k: bool(p[k]) if k in FLAGS else p[k] for k in p} | {"seed": seed + 1}
    with temporary_folder() as folder:
        models.build_fmu("drive", folder, law=drive.law)
        models.build_fmu("velocity_controller", folder)
        system = servo_loop(folder, loop)
        system.expose("F_ff", "controller.F_ff")
        with system.prepare(step=loop.T_s, stop=stop, record=measured) as simulation:
            result = simulation.run(
                {f"drive.{name}": value for name, value in start.items()},
                # The drive has no constant force; what the motor spends on it is left out here.
                loop.commands(v_cmd) | {"F_ff": np.full_like(v_cmd, -drive.constant)},
            )
    x, force = result[measured[0]], result[measured[1]] + drive.constant
    step = p.get("encoder_step", Datasheet().encoder_step)
    commands = {"velocity_command": v_cmd, "position_command": loop.commands(v_cmd).get("x_cmd")}
    recording = Recording(result.time, x, force, **commands, encoder_step=step)
    gains = gains_of(loop)
    wrong = {name: gains[name] * drive.gains for name in ("K_p", "K_i")}
    return recording, {**gains, **wrong} if drive.gains else None
