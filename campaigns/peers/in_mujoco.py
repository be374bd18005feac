"""``python -m campaigns.peers.in_mujoco FOLDER simulate|joint|lugre``, in the peers' Python.

MuJoCo simulates a data set, or ``mujoco.sysid`` fits a joint with ``frictionloss`` and ``damping``,
or one with the LuGre friction of ``dcmotor``. Prints JSON.
"""

import contextlib
import io
import json
import sys
import time
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from mujoco import rollout, sysid

from campaigns.peers.folder import Run, bob, facts, read

FOLDER, WHAT = Path(sys.argv[1]), sys.argv[2]
KNOWN = facts(FOLDER)
STEPS = 4  # for each sample: implicit damping D over a step h adds h D to the mass
MOST = 100  # iterations
XML = """<mujoco><option timestep="{step}" integrator="implicitfast"/><worldbody><body name="b">
<inertial pos="0 0 {com}" mass="{mass}" diaginertia="{inertia} {inertia} {inertia}"/>
<joint name="j" type="{joint}" axis="0 1 0"/></body></worldbody><actuator>
<position name="loop" joint="j" kp="{kp}" kv="{kv}" forcelimited="true" forcerange="-{u} {u}"/>
<general name="offset" joint="j" biastype="affine"/>{bristles}</actuator>
<sensor><jointpos name="x" joint="j"/><actuatorfrc name="F" actuator="loop"/></sensor></mujoco>"""
BRISTLES = """<dcmotor name="f" joint="j" resistance="1" motorconst="0 0" input="none"
lugre="1 1 1 1 1"/>"""  # passive friction as in MuJoCo's documentation: a motor without inputs


def spec_of(run: Run, law: str, steps: int = STEPS) -> Any:
    mass, com, inertia = bob(KNOWN) if any(KNOWN["load"]) else (1.0, 0.0, 1.0)
    text = XML.format(
        step=run.t[1] / steps,
        kp=run.K_p * run.K_x,
        kv=run.K_p,
        u=run.u_max,
        mass=mass,
        com=-com,
        inertia=inertia - mass * com**2,
        joint="hinge" if KNOWN["rotary"] else "slide",
        bristles=BRISTLES if law == "lugre" else "",
    )
    return mujoco.MjSpec.from_string(text)


def put(spec: Any, values: dict[str, float]) -> Any:
    """Write parameters of the drive into a model, and return it compiled."""
    joint, body = spec.joint("j"), spec.body("b")
    if any(KNOWN["load"]):
        joint.armature = values["m"]
    elif KNOWN["rotary"]:
        body.inertia = np.full(3, values["m"])
    else:
        body.mass = values["m"]  # frictionloss is scaled with the masses of bodies, not armature
    joint.damping[0] = values["b"]
    spec.actuator("offset").biasprm[0] = values.get("F_0", 0.0)
    if "sigma_0" in values:
        bristles = spec.actuator("f")
        bristles.dynprm[5:7] = values["sigma_0"], values["sigma_1"]
        bristles.biasprm[3:6] = values["F_c"], values["F_s"], values["v_s"]
    else:
        joint.frictionloss = values["F_c"]
    return spec.compile()


def start_of(model: Any, run: Run) -> Any:
    return sysid.create_initial_state(model, run.x[:1], run.v[:1], np.zeros(model.na))


def rolled(model: Any, run: Run) -> Any:
    """Return positions and forces (2, n) on the times of a run."""
    t = np.arange(0, run.t[-1] + model.opt.timestep / 2, model.opt.timestep)
    control = np.column_stack([np.interp(t, run.t, run.x_cmd), np.zeros_like(t)])
    sensors = rollout.rollout(model, mujoco.MjData(model), start_of(model, run), control)[1][0]
    return [np.interp(run.t, t, sensor) for sensor in sensors.T]


def simulate() -> dict[str, Any]:
    """Return runs of a drive with LuGre friction, at 1 kHz from steps of 0.02 ms."""
    runs: dict[str, Any] = {}
    for (name, sines), seconds in zip(KNOWN["commands"].items(), (20, 10), strict=True):
        t = np.arange(0, seconds, 1e-3)
        goal = np.minimum(t, 1.0) * sum(a * np.sin(2 * np.pi * f * t) for a, f in sines)
        run = Run(t, np.zeros_like(t), np.zeros_like(t), goal, **KNOWN["loops"][name])
        x, F = rolled(put(spec_of(run, "lugre", 50), KNOWN["truth"]), run)
        runs[name] = [signal.tolist() for signal in (t, x, F, goal)]
    return runs


def fit(law: str) -> dict[str, Any]:
    """Fit by mujoco.sysid; return what it found and its errors on the held-out run."""
    run, held, (m, F_c, b) = read(FOLDER, "train"), read(FOLDER, "held"), KNOWN["guess"]
    start = {"m": (m, 0.02, 4.0), "F_c": (F_c, 0.02, 4.0), "b": (b, 0.02, 4.0)}  # and factors
    if law == "lugre":
        sigma_0 = F_c / (1e-4 * np.ptp(run.x))
        start |= {"sigma_0": (sigma_0, 1e-2, 1e2), "F_s": (1.5, 1 / 1.5, 2.0)}  # of F_c
        start |= {"sigma_1": (np.sqrt(sigma_0 * m), 1e-2, 10.0)}
        start |= {"v_s": (0.05 * KNOWN["speed"], 1e-2, 10.0)}
    params = sysid.ParameterDict()
    for name, (at, low, high) in start.items():  # on a logarithmic scale
        params.add(sysid.Parameter(name, *np.log([at, low * at, high * at]), modifier=lambda *_: 0))
    params.add(sysid.Parameter("F_0", 0.0, -1.0, 1.0, modifier=lambda *_: 0))

    def values(at: Any) -> dict[str, float]:
        own = {name: float(np.exp(at[name].value[0])) for name in start}
        if law == "lugre":
            own["F_s"] *= own["F_c"]
        return {**own, "F_0": float(at["F_0"].value[0]) * F_c}

    spec = spec_of(run, law)
    model, step = spec.compile(), run.t[1] / STEPS
    control = sysid.TimeSeries(run.t, np.column_stack([run.x_cmd, np.zeros_like(run.t)]))
    # a sensor shows the begin of a step, and sysid gives it the time of the end
    shown = sysid.TimeSeries.from_names(run.t + step, np.column_stack([run.x, run.F]), model)
    logs = sysid.ModelSequences("drive", spec, "train", start_of(model, run), control, shown)
    residual = sysid.build_residual_fn(
        models_sequences=[logs], build_model=lambda at, spec: put(spec, values(at)), n_threads=1
    )
    begin = time.process_time()
    with contextlib.redirect_stdout(io.StringIO()):
        best, result = sysid.optimize(params, residual, optimizer="mujoco", max_iters=MOST)
    cpu, n = time.process_time() - begin, len(result.extras["objective"])
    left = residual(result.x, best)[0]
    half = dict(zip(start, sysid.calculate_intervals(left, result.jac)[1], strict=False))
    p = values(best)
    intervals = {k: [p[k] * np.exp(-half[k]), p[k] * np.exp(half[k])] for k in start if k != "F_s"}
    errors = held.errors(*rolled(put(spec_of(held, law), p), held))
    load = bob(KNOWN)[2]
    p["m"], intervals["m"] = p["m"] + load, [load + end for end in intervals["m"]]
    note = f"{n} iterations" + ("" if n < MOST else ", not converged")
    return {"found": p, "intervals": intervals, **errors, "cpu": cpu, "note": note}


print(json.dumps(simulate() if WHAT == "simulate" else fit(WHAT)))
