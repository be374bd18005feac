"""``python -m campaigns.peers --bam FOLDER --pendulum FOLDER --python PYTHON --out DIR``.

Gives the same runs to BAM, ``mujoco.sysid`` and ``stickslip learn``, one core each, and writes what
each finds and how it predicts a run that was not fitted (docs/measurements/peers.md). ``--bam`` and
``--pendulum`` are checkouts of Rhoban/bam and of torque_limited_simple_pendulum of
dfki-ric-underactuated-lab; ``--python`` has mujoco[sysid], optuna 4.2, cmaes and colorama.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.integrate import solve_ivp
from scipy.io import loadmat
from scipy.signal import savgol_filter

import stickslip as ss
from campaigns.peers.folder import Array, bob, facts

SETS = tomllib.loads(Path(__file__).with_name("sets.toml").read_text(encoding="utf-8"))
ALONE = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
RUNS = ("train", "held")
NOISE = 0.005  # of the measured force, of F_c
Row = dict[str, Any]
Signals = tuple[Array, ...]
"""Of a run, as ``Run`` has them: t, x, F, x_cmd."""


def lugre(known: Row, t: Array, x_cmd: Array) -> Signals:
    """Return a run of a slider with LuGre friction by a stiff solver, in continuous time."""
    p, loop = known["truth"], known["loops"]["train"]

    def force(at: Any, x: Any, v: Any) -> Any:
        return loop["K_p"] * (loop["K_x"] * (np.interp(at, t, x_cmd) - x) - v)

    def slope(at: float, y: Array) -> list[float]:
        x, v, z = y
        g = p["F_c"] + (p["F_s"] - p["F_c"]) * np.exp(-((v / p["v_s"]) ** 2))
        dz = v - p["sigma_0"] * abs(v) * z / g
        friction = p["sigma_0"] * z + p["sigma_1"] * dz + p["b"] * v
        return [v, (force(at, x, v) - friction) / p["m"], dz]

    options: Any = {"method": "LSODA", "rtol": 1e-7, "atol": [1e-11, 1e-9, 1e-12]}
    y = solve_ivp(slope, t[[0, -1]], [0.0] * 3, t_eval=t, max_step=2e-3, **options).y
    return t, y[0], force(t, y[0], y[1]), x_cmd


def slider(known: Row) -> dict[str, Signals]:
    limits = ss.Limits(stroke=0.2, speed=known["speed"], acceleration=3.0, rate=1000.0)
    plan, t = ss.plan(limits), np.arange(0, 10, 1e-3)
    sines = 0.04 * np.sin(2 * np.pi * 0.3 * t) + 0.012 * np.sin(2 * np.pi * 1.1 * t)
    own = plan["time"].to_numpy(), plan["position_command"].to_numpy()
    return {"train": lugre(known, *own), "held": lugre(known, t, np.minimum(t, 1.0) * sines)}


def emps(known: Row) -> dict[str, Signals]:
    log = loadmat("../shared/data/emps/DATA_EMPS.mat", squeeze_me=True)
    loop = {"K_x": float(log["kp"]), "K_p": float(log["kv"] * log["gtau"]), "u_max": 1e6}
    known["loops"] = dict.fromkeys(RUNS, loop)
    signals = np.array([log["t"], log["qm"], log["gtau"] * log["vir"], log["qg"]])
    halves = np.array_split(signals, 2, axis=1)
    halves[1][0] -= halves[1][0, 0]
    return {name: tuple(half) for name, half in zip(RUNS, halves, strict=True)}


def pendulum(known: Row, folder: Path) -> dict[str, Signals]:
    """Return swing-ups in a loop that gives the logged torque on the logged motion.

    This loop is not the robot's: it keeps a model near the log, as ``--reset_period`` of BAM does.
    """
    loop, runs = known["replayed"], {}
    known["loops"] = dict.fromkeys(RUNS, loop)
    for name, motion in known["runs"].items():
        log = pd.read_csv(folder / "results" / f"control_method_{motion}" / "data_measured.csv")
        step = float(np.median(np.diff(log["time"])))
        t = np.arange(0, log["time"].iloc[-1], step)
        x, F = (np.interp(t, log["time"], log[key]) for key in ("position", "torque"))
        n = 2 * round(0.02 / step) + 1  # steps of the encoder are 2.9 mrad
        x, v = (savgol_filter(x, n, 3, deriv=order, delta=step) for order in (0, 1))
        runs[name] = (t, x, F, x + (F / loop["K_p"] + v) / loop["K_x"])
    return runs


def learn(folder: Path, *, given: bool = False, options: tuple[str, ...] = ()) -> Row:
    """Run ``stickslip learn`` and ``validate``.

    Where it is ``given``, the gravity of the load is a force that was added to the controller's.
    """
    known, out = facts(folder), folder / "_".join(["ours", *["given"] * given, *options[1:]])
    mass, com, _ = bob(known)
    loops = {}
    out.mkdir(exist_ok=True)
    for name, gains in known["loops"].items():
        log = pd.read_csv(folder / f"{name}.csv")
        if given:
            log["added_force [N.m]"] = -mass * 9.80665 * com * np.sin(log["position [rad]"])
            log["force [N.m]"] += log["added_force [N.m]"]
        log.to_csv(out / f"{name}.csv", index=False)
        values = (f"{key}={value:.9g}" for key, value in gains.items())
        loops[name] = ["--controller", "P-P", "--gain", *values]
    own = [] if "replayed" in known else loops["train"]
    me, file = [sys.executable, "-m", "stickslip"], out / "learned" / "learned.json"
    own += [*options, "--workers", "1", "--seed", "1", "--force", "--out", str(file.parent)]
    captured: Any = {"env": ALONE, "capture_output": True, "text": True}
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    said = subprocess.run([*me, "learn", str(out / "train.csv"), *own], **captured)
    row: Row = {"cpu": resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, "note": ""}
    (out / "said.txt").write_text(said.stdout + said.stderr, encoding="utf-8")
    if said.returncode == 0:
        learned = json.loads(file.read_text(encoding="utf-8"))["parameters"]
        row["found"] = {name: one["value"] for name, one in learned.items()}
        row["intervals"] = {name: [one["low"], one["high"]] for name, one in learned.items()}
        hidden = (k for k, one in learned.items() if one["identifiability"] == "not identifiable")
        row["hidden"] = list(hidden)
        own = ["--json", "--log", str(out / "held.csv"), *loops["held"]]
        said = subprocess.run([*me, "validate", str(file), *own], **captured)
    if said.returncode:
        return {**row, "note": said.stderr.strip().splitlines()[-1][:150]}
    errors = json.loads(said.stdout)["signals"]
    if "position" not in errors:
        return {**row, "note": "the simulated loop diverges"}
    force = errors["closed_loop_force"]["relative"]
    return {**row, "position": errors["position"]["error"], "force": force}


def rows_of(name: str, given: argparse.Namespace) -> Iterator[tuple[str, Row]]:
    """Make a data set unless it is there; yield what each tool does with it."""
    folder = given.out / name

    def peer(module: str, what: str) -> Row:
        command = [given.python, "-m", f"campaigns.peers.{module}", str(folder), what]
        command += [str(given.bam), str(given.trials)]
        done = subprocess.run(command, env=ALONE, stdout=subprocess.PIPE, check=True)
        return dict(json.loads(done.stdout.splitlines()[-1]))

    if not (folder / "held.csv").exists():
        known, makes = dict(SETS[name]), {"slider": slider, "emps": emps}
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "set.json").write_text(json.dumps(known), encoding="utf-8")
        if name in makes:
            runs = makes[name](known)
        elif name == "pendulum":
            runs = pendulum(known, given.pendulum)
        else:
            runs = peer(f"in_{name}", "simulate")
            known["truth"] = runs.pop("truth", known.get("truth"))
        (folder / "set.json").write_text(json.dumps(known, indent=1), encoding="utf-8")
        length, force = ("rad", "N.m") if known["rotary"] else ("m", "N")
        head = f"t [s],position [{length}],force [{force}],position_command [{length}]"
        random = np.random.default_rng(45)
        for run, (t, x, F, x_cmd) in runs.items():
            if "truth" in known:
                x = known["encoder"] * np.round(np.asarray(x) / known["encoder"])
                F = F + NOISE * known["truth"]["F_c"] * random.standard_normal(len(F))
            table = np.transpose([t, x, F, x_cmd])
            np.savetxt(folder / f"{run}.csv", table, "%.9g", ",", header=head, comments="")
    if "ours" in given.tools:
        yield "stickslip", learn(folder)
        if load := any(SETS[name]["load"]):
            yield "stickslip, gravity given", learn(folder, given=True)
        if "replayed" not in SETS[name]:
            loop = ("--criterion", "loop")
            yield "stickslip, --criterion loop", learn(folder, given=load, options=loop)
    if "sysid" in given.tools:
        for law in ("joint", "lugre"):
            yield f"mujoco.sysid, {law}", peer("in_mujoco", law)
    if "bam" in given.tools:
        for model in ("m1", "m2", "m3", "m4", "m5", "m6"):
            yield f"BAM {model.upper()}", peer("in_bam", model)


def table(known: Row, rows: dict[str, Row]) -> str:
    """Return a table of Markdown: relative errors of parameters, errors on the held-out run."""
    true = known.get("truth", known.get("published", {}))
    keys = list(true) or ["m", "F_c", "b"]
    unit = "mrad" if known["rotary"] else "mm"
    heads = ["tool", *keys, "intervals that hold"]
    heads += [f"position held out, {unit}", "force held out, %", "processor time, s", "note"]
    lines = [f"## {known['title']}", "", f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for name, row in sorted(rows.items(), key=lambda item: item[1].get("position", np.inf)):
        found, intervals, cells = row.get("found", {}), row.get("intervals", {}), [name]
        for key in keys:
            value = found.get(key, np.nan)
            text = f"{100 * (value / true[key] - 1):+.1f} %" if true else f"{value:.3g}"
            text = f"({text})" if key in row.get("hidden", ()) else text
            cells.append("" if np.isnan(value) else text)
        hold = [low <= true[k] <= high for k, (low, high) in intervals.items() if k in true]
        cells.append(f"{sum(hold)} of {len(hold)}" if hold else "")
        cells.append(f"{1e3 * row['position']:.3g}" if "position" in row else "")
        cells.append(f"{100 * row['force']:.3g}" if "position" in row else "")
        lines.append(f"| {' | '.join([*cells, format(row['cpu'], '.0f'), row['note']])} |")
    return "\n".join([*lines, ""])


def main() -> None:
    """Let every tool work on each data set; write and print a table of each."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    for name in ("--bam", "--pendulum", "--out"):
        options.add_argument(name, type=Path, required=True)
    options.add_argument("--python", required=True)
    options.add_argument("--trials", type=int, default=800, help="of each fit by BAM")
    options.add_argument("--sets", nargs="+", choices=SETS, default=list(SETS))
    options.add_argument("--tools", nargs="+", default=["ours", "sysid", "bam"])
    given = options.parse_args()
    for name in given.sets:
        kept = given.out / f"{name}.json"
        rows = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {}
        for tool, row in rows_of(name, given):
            rows[tool] = row
            kept.write_text(json.dumps(rows, indent=1), encoding="utf-8")
        print(table(facts(given.out / name), rows), flush=True)


if __name__ == "__main__":
    main()
