"""``python -m campaigns.peers.in_bam FOLDER simulate|m1|...|m6 BAM TRIALS``, in the peers' Python.

BAM simulates a data set, or its own ``bam.fit`` fits one of its models as in its documentation but
for the number of trials. Prints JSON.
"""

import contextlib
import io
import json
import runpy
import sys
import time
import types
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.peers.folder import Run, bob, facts, read

FOLDER, WHAT, BAM, TRIALS = Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3]), sys.argv[4]
sys.path.insert(0, str(BAM))
sys.modules["wandb"] = types.ModuleType("wandb")  # bam.fit imports it, and uses it when asked to

import bam.actuators  # noqa: E402
import optuna  # noqa: E402
from bam.actuator import Actuator  # noqa: E402
from bam.model import models  # noqa: E402
from bam.parameter import Parameter  # noqa: E402
from bam.simulate import Simulator  # noqa: E402
from bam.testbench import Pendulum  # noqa: E402
from bam.trajectory import trajectories  # noqa: E402

KNOWN = facts(FOLDER)
SPEED = 5.0  # of the shaft [rad/s]: BAM looks for Stribeck velocities of 0.1 to 3 rad/s
PIECE = 1.0  # of a run for a log [s]: BAM takes many logs, and simulates all at once
SHAFT = 1.0 if KNOWN["rotary"] else SPEED / KNOWN["speed"]  # rad per m: it drives a slider


class InLoop(Actuator):  # type: ignore[misc]
    """An actuator whose torque is known, in a loop whose gains are known."""

    def initialize(self) -> None:
        m, F_c, b = KNOWN["guess"]
        self.model.armature = Parameter(m / SHAFT**2, 0.1 * m / SHAFT**2, 4 * m / SHAFT**2)
        self.model.max_friction_base = 3 * F_c / SHAFT
        self.model.max_viscous_friction = 3 * b / SHAFT**2

    def load_log(self, log: dict[str, Any]) -> None:
        super().load_log(log)
        self.K_x, self.K_p, self.u_max = log["K_x"], log["K_p"], log["u_max"]

    def compute_control(self, q_target: Any, q: Any, dq: Any, dt: float) -> Any:  # noqa: ARG002
        u = self.K_p * (self.K_x * (q_target - q) - dq)
        return self.backend.clamp(u, -self.u_max, self.u_max)

    def compute_torque(self, control: Any, torque_enable: Any, q: Any, dq: Any) -> Any:  # noqa: ARG002
        return control * torque_enable

    def get_extra_inertia(self) -> float:
        return float(self.model.armature.value)


bam.actuators.actuators["peers"] = lambda: InLoop(Pendulum)


def model_of(name: str, values: dict[str, float]) -> Any:
    model = models[name]()
    model.set_actuator(InLoop(Pendulum))
    model.load_parameters_from_dict(values)
    return model


def found(model: Any) -> dict[str, float]:
    """Return what other tools find, too, without what depends on the load."""
    p = {name: one.value for name, one in model.get_parameters().items()}
    F_c, m = p["friction_base"], bob(KNOWN)[2] + p["armature"]
    values = {"m": m * SHAFT**2, "F_c": F_c * SHAFT, "b": p["friction_viscous"] * SHAFT**2}
    if model.stribeck:
        values |= {"F_s": (F_c + p["friction_stribeck"]) * SHAFT}
        values |= {"v_s": p["dtheta_stribeck"] / SHAFT}
    return values


def log_of(run: Run, begin: float = 0.0, length: float = np.inf) -> dict[str, Any]:
    """Return a stretch of a run as a processed log of BAM."""
    used = (run.t >= begin) & (run.t < begin + length)
    signals = {"position": run.x, "speed": run.v, "goal_position": run.x_cmd}
    rows = np.transpose([SHAFT * signal[used] for signal in signals.values()]).tolist()
    entries = [{**dict(zip(signals, row, strict=True)), "torque_enable": True} for row in rows]
    gains = {"K_x": run.K_x, "K_p": run.K_p / SHAFT**2, "u_max": run.u_max / SHAFT, "kp": 1}
    load = dict(zip(("mass", "arm_mass", "length"), KNOWN["load"], strict=True))
    return {**load, **gains, "dt": float(run.t[1]), "entries": entries}


def rolled(model: Any, run: Run) -> tuple[Any, Any]:
    """Return positions and forces (n,) of a model in the loop of a run."""
    x, _, u = Simulator(model).rollout_log(log_of(run), simulate_control=True)
    return np.array(x) / SHAFT, np.array(u) * SHAFT


def simulate() -> dict[str, Any]:
    """Return runs of a motor with published parameters along BAM's trajectories, and the truth."""
    published = BAM / "bam" / "params" / KNOWN["motor"] / f"{KNOWN['model']}.json"
    model = model_of(KNOWN["model"], json.loads(published.read_text(encoding="utf-8")))
    runs: dict[str, Any] = {"truth": {name: found(model)[name] for name in ("m", "F_c", "b")}}
    for name, parts in KNOWN["commands"].items():
        goal = np.zeros(200)
        for trajectory, share in parts:
            angles = [share * trajectories[trajectory](t)[0] for t in np.arange(0, 6, 1e-3)]
            back = angles[-1] * 0.5 * (1 + np.cos(np.linspace(0, np.pi, 1000)))
            goal = np.concatenate([goal, angles, back])
        t, rest = np.arange(len(goal)) * 1e-3, np.zeros_like(goal)
        x, F = rolled(model, Run(t, rest, rest, goal, **KNOWN["loops"][name]))
        runs[name] = [signal.tolist() for signal in (t, x, F, goal)]
    return runs


def fit(name: str) -> dict[str, Any]:
    """Run bam.fit; return what it found and its errors on the held-out run."""
    run, held = read(FOLDER, "train"), read(FOLDER, "held")
    logs, studies, create = FOLDER / "bam_logs", [], optuna.create_study
    logs.mkdir(exist_ok=True)
    for k in range(round(run.t[-1] / PIECE)):
        (logs / f"{k}.json").write_text(json.dumps(log_of(run, k * PIECE, PIECE)))

    def keep(**options: Any) -> Any:
        studies.append(create(**options))
        return studies[-1]

    optuna.create_study = keep
    sys.argv = ["bam.fit", "--actuator", "peers", "--model", name, "--logdir", str(logs)]
    sys.argv += ["--output", str(FOLDER / f"bam_{name}.json"), "--trials", TRIALS]
    begin = time.process_time()
    with contextlib.redirect_stdout(io.StringIO()):
        runpy.run_module("bam.fit", run_name="__main__")
    cpu, values = time.process_time() - begin, [one.value for one in studies[0].trials]
    half, end = min(values[: len(values) // 2]), min(values)
    note = f"{100 * (1 - end / half):.0f} % of the cost in the last half of the trials"
    model = model_of(name, studies[0].best_params)
    best = studies[0].best_params
    errors = held.errors(*rolled(model, held))
    return {"found": found(model), **errors, "cpu": cpu, "note": note, "best": best}


print(json.dumps(simulate() if WHAT == "simulate" else fit(WHAT)))
