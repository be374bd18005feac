"""Sound drives drawn at random, their logs, and what is true of them.

A rotary drive is a linear one behind a radius: read rad for m, N m for N, kg m2 for kg.
"""

import json
import math
import shutil
import subprocess
import sys
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.linalg import expm

from campaigns.sound_drives import simulator

STICKSLIP = str(Path(sys.executable).with_name("stickslip"))
"""The command that is measured: that of the environment which runs the campaign."""
LAWS = ("lugre", "gms", "elasto_plastic", "dahl", "coulomb_stribeck")
ENCODER_NOISE = 0.3  # standard deviation [steps]
DURATION = 20.0  # of a log [s]
MARGIN = 2.0
"""Factor of the controller gains with which the loop is still stable, free and where it sticks."""
DAMPING = {"lugre": (0.3, 1.2), "elasto_plastic": (0.3, 1.2), "gms": (0.1, 0.5)}
"""sigma_1 / (2 sqrt(sigma_0 m))."""
BREAK_AWAY = (0.3, 0.9)  # deflection at which an elasto-plastic contact yields, over F_c / sigma_0
AXES = ("horizontal", "vertical", "arm", "geared", "cogging")
ARMS = ("arm", "geared")
HEAVIEST = 5.0  # weight of a vertical axis or an arm, in F_c


@dataclass(frozen=True)
class Drive:
    """A drive in its loop."""

    name: str
    seed: int  # of the noise of its log
    law: str
    rotary: bool
    parameters: dict[str, float]  # of the simulator, by name
    noise_F: float  # standard deviation of the measured force [N]
    speed: float  # largest of its motions [m/s]
    acceleration: float  # [m/s2]
    stroke: float  # [m]
    bandwidth: float  # of the velocity loop [Hz]
    axis: str = "horizontal"  # one of ``AXES``
    travel: tuple[float, float] = (0.0, 0.0)  # lowest and highest position of its log [m]

    @property
    def learn(self) -> list[str]:
        """Arguments of ``stickslip learn`` behind the log."""
        gains = (f"{name}={value!r}" for name, value in self.gains.items())
        return ["--controller", self.controller, "--gain", *gains]

    @property
    def deflection(self) -> float:
        """Presliding deflection F_c / sigma_0 [m]."""
        return self.parameters["F_c"] / self.parameters["sigma_0"]

    @property
    def controller(self) -> str:
        """Kind of controller, as ``stickslip learn`` calls it."""
        return "P-PI" if self.parameters["K_x"] else "PI"

    @property
    def gains(self) -> dict[str, float]:
        """Gains that ``stickslip learn`` is told, by name."""
        outer = ("K_x", "velocity_feedforward") if self.parameters["K_x"] else ()
        names = (*outer, "K_p", "K_i", "tau_f", "T_s", "u_max")
        return {name: self.parameters[name] for name in names}

    @property
    def position_force(self) -> dict[str, float]:
        """The force of position by name; F_0 has half of what friction forward has more."""
        p = self.parameters
        if self.axis == "cogging":
            names = {"pitch": "pitch", "cogging_s[1]": "s_1", "cogging_c[1]": "c_1"}
            names |= {"cogging_s[2]": "s_2", "cogging_c[2]": "c_2"}
            return {name: p[own] for name, own in names.items()}
        F_0 = {"F_0": p["F_0"] + p["asymmetry"] * p["F_c"]}
        if self.axis not in ARMS:
            return F_0
        names = ("g_s", "g_c", *(("mu_g",) if self.axis == "geared" else ()))
        return {name: p[name] for name in names}

    @property
    def truth(self) -> dict[str, float]:
        """What the intervals should hold; friction is the mean over the travel of the log."""
        p = self.parameters
        x = np.linspace(*self.travel, 2001) - p["origin"]
        along = 1.0 + float(np.mean(p["uneven"] * np.sin(2.0 * np.pi * x / p["period"])))
        found = {name: p[name] for name in ("m", "b", "v_s", "sigma_0")}
        found |= {name: along * p[name] for name in ("F_c", "F_s")}
        absent = {"dahl": ("v_s", "F_s"), "coulomb_stribeck": ("sigma_0",)}.get(self.law, ())
        return {name: value for name, value in found.items() if name not in absent}

    def write(self, path: Path) -> None:
        """Write it as JSON."""
        told = {"learn": self.learn, "truth": self.truth}
        text = json.dumps(asdict(self) | told, indent=1)
        path.write_text(text + "\n", encoding="utf-8")

    @classmethod
    def read(cls, path: Path) -> "Drive":
        """Read what ``write`` wrote."""
        values = json.loads(path.read_text(encoding="utf-8"))
        return cls(**{one.name: values[one.name] for one in fields(cls)})


def draw(seed: int, number: int, axis: str = "horizontal") -> Drive:
    """Return the drive of this number; laws, kinds of motion and loops take turns."""
    rng = np.random.default_rng([seed, number])
    while True:
        drive = _candidate(rng, number, axis)
        if _usable(drive):
            return drive if axis == "horizontal" else _loaded(drive, rng)


def _loaded(drive: Drive, rng: np.random.Generator) -> Drive:
    """Return a drive with the force of position of its axis, which its integral holds at first."""
    p, F_c = dict(drive.parameters), drive.parameters["F_c"]
    weight = HEAVIEST * F_c * np.exp(rng.uniform(np.log(0.1), 0.0))
    first, second = F_c * rng.uniform(0.1, 1.0), rng.uniform(0.2, 0.6)
    phases = 2.0 * math.pi * rng.uniform(size=2)
    if drive.axis == "vertical":
        p["F_0"] += math.copysign(weight, phases[0] - math.pi)
    elif drive.axis in ARMS:
        p |= {"g_s": weight * math.sin(phases[0]), "g_c": weight * math.cos(phases[0])}
        if drive.axis == "geared":
            p["mu_g"] = float(np.exp(rng.uniform(np.log(0.05), np.log(0.3))))
    else:
        p["pitch"] = min(p["period"] * rng.uniform(0.5, 2.0), drive.stroke / 2.5)
        for k, size in ((1, first), (2, second * first)):
            p |= {
                f"s_{k}": size * math.sin(phases[k - 1]),
                f"c_{k}": size * math.cos(phases[k - 1]),
            }
    p["motor"] = p["held"] = sum(p.get(name, 0.0) for name in ("F_0", "g_c", "c_1", "c_2"))
    p["u_max"] += weight if drive.axis != "cogging" else (1.0 + second) * first
    return replace(drive, parameters={name: float(value) for name, value in p.items()})


def _candidate(rng: np.random.Generator, number: int, axis: str) -> Drive:
    def log(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    law, rotary = LAWS[number % len(LAWS)], number % 2 == 1 or axis in ARMS
    radius = log(5e-3, 3e-2) if rotary else 1.0
    if axis in ARMS:
        radius = log(0.02, 0.1)
    m = log(2e-5, 2e-2) if rotary else log(0.3, 60.0)
    F_c = m * log(0.3, 3.0) / radius
    F_s = F_c * rng.uniform(1.05, 2.0)
    speed, acceleration = log(0.03, 0.2) / radius, log(1.0, 8.0) / radius
    b = F_c * log(0.05, 0.6) / speed
    encoder = 2.0 * math.pi / 2 ** int(rng.integers(17, 23)) if rotary else log(5e-8, 5e-6)
    sigma_0 = F_c / (encoder * log(4.0, 400.0))
    T_s, bandwidth = float(rng.choice([1e-3, 5e-4, 1e-4])), rng.uniform(18.0, 45.0)
    K_p = 2.0 * math.pi * bandwidth * m * rng.uniform(0.8, 1.2)  # for the mass of a data sheet
    cascade = number // 2 % 2 == 1
    parameters = {
        "m": m,
        "b": b,
        "F_c": F_c,
        "F_s": F_c if law == "dahl" else F_s,
        "v_s": log(5e-4, 1e-2) / radius,
        "delta": float(rng.choice([1.0, 2.0])),
        "sigma_0": sigma_0,
        "sigma_1": 2.0 * math.sqrt(sigma_0 * m) * rng.uniform(*DAMPING.get(law, (0.0, 0.0))),
        "asymmetry": rng.uniform(-0.05, 0.05),
        "uneven": rng.uniform(0.0, 0.1),
        "period": log(5e-3, 6e-2) / radius,
        "origin": 0.0,
        "F_0": F_c * rng.uniform(-0.05, 0.05),
        "K_p": K_p,
        "K_i": K_p * 2.0 * math.pi * bandwidth / rng.uniform(4.0, 8.0),
        "K_x": 2.0 * math.pi * bandwidth / rng.uniform(5.0, 10.0) if cascade else 0.0,
        "velocity_feedforward": float(rng.choice([1.0, rng.uniform(0.5, 1.0)])) if cascade else 1.0,
        # a step of the encoder commands half of F_c at most
        "tau_f": max(T_s * rng.uniform(0.5, 2.5), 2.0 * K_p * encoder / F_c),
        "T_s": T_s,
        "u_max": rng.uniform(1.5, 3.0) * (F_s + b * speed + m * acceleration),
        "encoder": encoder,
        "phase": rng.uniform(),
        "z_ba": rng.spawn(1)[0].uniform(*BREAK_AWAY),
    }
    return Drive(
        name=f"drive_{number:02}",
        seed=number,
        law=law,
        rotary=rotary,
        parameters=parameters,
        noise_F=F_c * log(2e-3, 2e-2),
        speed=speed,
        acceleration=acceleration,
        stroke=rng.uniform(1.0, 3.0) if axis in ARMS else log(0.05, 0.3) / radius,
        bandwidth=bandwidth,
        axis=axis,
    )


def _usable(drive: Drive) -> bool:
    """Whether the loop has a gain margin, and stroke and speed show friction."""
    p = drive.parameters
    stuck = {"b": p["b"] + p["sigma_1"], "stiffness": p["sigma_0"]}
    stable = all(
        _spectral_radius({**p, **plant}, gain) < 1.0 - 1e-9
        for plant in ({"stiffness": 0.0}, stuck)
        for gain in (1.0, MARGIN)
    )
    room = 60.0 * drive.deflection < 0.5 * drive.stroke and 8.0 * p["v_s"] < drive.speed
    return stable and room


def _spectral_radius(p: dict[str, float], gain: float) -> float:
    """Return that of the sampled loop around a mass on a spring.

    The state is position, velocity, last position, velocity estimate and integral.
    """
    A = np.array([[0, 1, 0], [-p["stiffness"] / p["m"], -p["b"] / p["m"], 1 / p["m"]], [0, 0, 0]])
    step, weight = expm(A * p["T_s"]), 1.0 - math.exp(-p["T_s"] / p["tau_f"])
    x, v, last, estimate, integral = np.eye(5)
    estimate = estimate + weight * ((x - last) / p["T_s"] - estimate)
    e = -p["K_x"] * x - estimate
    integral = integral + p["T_s"] * p["K_i"] * gain * e
    moved = step @ np.array([x, v, p["K_p"] * gain * e + integral])
    closed = np.array([moved[0], moved[1], x, estimate, integral])
    poles = np.sort(np.abs(np.linalg.eigvals(closed)))
    return float(poles[-1] if p["K_x"] else poles[-2])  # no position loop: any position stays


def write_log(
    drive: Drive, folder: Path, encoder_noise: float = ENCODER_NOISE, *, several: bool = False
) -> Drive:
    """Record the planned experiment; write log and drive, and return it with its travel.

    Several experiments, one for each kind of motion, become logs in a folder of their own.
    """
    commands = _planned(drive, folder, several=several)
    low, high = np.inf, -np.inf
    for k, (path, command) in enumerate(commands.items()):
        x = _record(drive, path, command, encoder_noise, seed=drive.seed + 1000 * k)
        low, high = min(low, x.min()), max(high, x.max())
    drive = replace(drive, travel=(float(low), float(high)))
    drive.write(folder / f"{drive.name}.json")
    return drive


def _record(
    drive: Drive, path: Path, command: pd.DataFrame, encoder_noise: float, seed: int
) -> np.ndarray:
    """Write the log of a command, and return the true positions (n,)."""
    unit = "rad" if drive.rotary else "m"
    v_cmd, x_cmd = command["velocity_command"], command["position_command"]
    found = simulator.run(
        drive.law,
        drive.parameters,
        v_cmd.to_numpy(),
        x_cmd=x_cmd.to_numpy(),
        noise=(encoder_noise, drive.noise_F),
        seed=seed,
    )
    log = {
        "time [s]": command["time"],
        f"position [{unit}]": found["encoder"],
        "torque [N.m]" if drive.rotary else "force [N]": found["force"],
        f"velocity_command [{unit}/s]": v_cmd,
        f"position_command [{unit}]": x_cmd,
    }
    pd.DataFrame(log).to_csv(path, index=False, float_format="%.10g")
    return np.asarray(found["x"])


def _planned(drive: Drive, folder: Path, *, several: bool) -> dict[Path, pd.DataFrame]:
    """Return what ``stickslip plan`` proposes for the limits of the drive, by its log's path."""
    limits = {name: getattr(drive, name) for name in ("stroke", "speed", "acceleration")}
    limits |= {"duration": DURATION, "rate": 1.0 / drive.parameters["T_s"]}
    options = [f"--{name}={value:.6g}" for name, value in limits.items()]
    if drive.axis in ARMS:
        options.append(f"--travel={0.5 * drive.stroke:.6g}")
    if drive.axis in (*ARMS, "cogging"):
        options += ["--show", "position_force"]
    options += ["--motion", "rotary" if drive.rotary else "linear", "--force"]
    plan, found = folder / f"{drive.name}_plan", {}
    options += ["--set", f"--out={plan}"] if several else [f"--out={plan / 'plan.csv'}"]
    plan.mkdir(exist_ok=True)
    subprocess.run([STICKSLIP, "plan", "-q", *options], check=True)
    logs = folder / drive.name
    for path in sorted(plan.glob("*.csv")):
        if path.name == "runs.csv":
            logs.mkdir(exist_ok=True)
            shutil.copy(path, logs)
            continue
        log = logs / f"{path.stem}_log.csv" if several else folder / f"{drive.name}.csv"
        command = pd.read_csv(path)
        found[log] = command.rename(columns=lambda name: name.partition(" ")[0])
    shutil.rmtree(plan)
    return found
