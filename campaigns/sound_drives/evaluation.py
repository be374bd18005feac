"""What ``stickslip learn`` wrote, in the loop of the drive that made the log."""

import ctypes
import json
import math
import statistics
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.sound_drives import simulator
from campaigns.sound_drives.drives import ENCODER_NOISE, STICKSLIP, Drive
from stickslip.fmi.toolchain import shared_library

MOTIONS = ("fast", "slow", "creep", "move_60", "move_4")
PREDICTED = {"move_4": "micro-steps", "move_60": "short moves", "creep": "creep"}
"""Motion -> the one that is most like it in the predictions of ``learn``; else by its speed."""
LEVELS = (1.0, 0.7, 1.3)
"""F_c and F_s of the drive, relative to those at the log."""
SEEDS = (1, 2, 3)
REST = 0.1  # before and after each motion [s]
SETTLING = 1.0  # of observer and integral before it, where the axis holds a force of position [s]
INTERVALS = ("m", "b", "F_c", "F_s", "v_s", "sigma_0")
AT_REST = {"motor": 0.0, "held": 0.0}  # of the loop without friction and force of position
PARTS = ("compensator", "position_force", "observer")
GLUE = """#include "added_force.h"
static AddedForce all;
#pragma GCC visibility push(default)
void begin(double v_cmd, double x_cmd, double x_enc, double F_m) {
    added_force_init(&all, v_cmd, x_cmd, 0.0, x_enc, F_m);
}
double added(double v_cmd, double x_cmd, double x_enc, double F_m) {
    return added_force_step(&all, v_cmd, x_cmd, 0.0, x_enc, F_m) ? all.F : 0.0;
}
"""


def motion(drive: Drive, name: str) -> np.ndarray:
    """Return velocities [m/s], one a sample: forward, a rest, and back; moves twice each way."""
    p = drive.parameters
    T_s, rest = p["T_s"], np.zeros(round(REST / p["T_s"]))
    if name.startswith("move"):
        length = float(name.removeprefix("move_")) * drive.deflection
        ramp = max(math.sqrt(2.0 * length / drive.acceleration), length / drive.speed)
        ramp = max(ramp, 1.0 / drive.bandwidth)
        pulse = _trapezoid(length / ramp, ramp, 0.0, T_s)
        return np.concatenate([rest, *2 * [pulse, rest], *2 * [-pulse, rest]])
    speed = {"fast": drive.speed, "slow": 0.1 * drive.speed, "creep": 0.3 * p["v_s"]}[name]
    ramp = max(2.0 * speed / drive.acceleration, 1.0 / drive.bandwidth)
    longest = 0.8 * drive.stroke / speed - ramp
    cruise = min(max(20.0 * drive.deflection / speed, 0.5), 3.0, longest)
    pulse = _trapezoid(speed, ramp, cruise, T_s)
    return np.concatenate([rest, pulse, rest, -pulse, rest])


def _trapezoid(speed: float, ramp: float, cruise: float, T_s: float) -> np.ndarray:
    corners = np.cumsum([0.0, ramp, cruise, ramp])
    t = np.arange(round(corners[-1] / T_s) + 1) * T_s
    return np.interp(t, corners, [0.0, speed, speed, 0.0])


def ratios(drive: Drive, level: float, compensator: ctypes.CDLL) -> dict[str, float]:
    """Return errors with a compensator over those without, by motion; medians over ``SEEDS``."""
    found = {}
    for name in MOTIONS:
        v_cmd = motion(drive, name)
        pairs = [[error(drive, v_cmd, level, s, c) for c in (compensator, None)] for s in SEEDS]
        found[name] = statistics.median(w / without for w, without in pairs)
    return found


def error(
    drive: Drive, v_cmd: np.ndarray, level: float, seed: int, compensator: ctypes.CDLL | None
) -> float:
    """Return the RMS of the true velocity minus that of the loop without friction [m/s].

    The seed sets noise, the phase of the encoder and the place on the guide.
    """
    first = 0 if drive.axis == "horizontal" else round(SETTLING / drive.parameters["T_s"])
    v_cmd = np.concatenate([np.zeros(first), v_cmd])
    driven = _driven(drive, v_cmd, level, seed, compensator=compensator)
    linear = simulator.run("none", {**drive.parameters, "encoder": 0.0, **AT_REST}, v_cmd)
    return _rms((driven["v"] - linear["v"])[first:])


def tuned_ratios(drive: Drive, learned: Path, tuned: Path) -> dict[str, Any]:
    """Return errors against the command in a tuned loop over those in the present one.

    ``learned`` is the present loop with what ``learn`` wrote, ``plain`` that without it. The errors
    are those of the velocity v, in a cascade also of the position x.
    """
    document = json.loads((tuned / "tuned.json").read_text(encoding="utf-8"))
    own = document["loop"].keys() & drive.parameters.keys() - {"m", "b"}
    gains = {name: document["loop"][name]["value"] for name in own}
    after = replace(drive, parameters={**drive.parameters, **gains})
    found: dict[str, list[float]] = {}
    with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as other:
        blocks = _exported_if(learned, Path(one)), _exported_if(tuned, Path(other))
        loops = {"learned": (drive, blocks[0]), "plain": (drive, None), "tuned": (after, blocks[1])}
        for level, name in product(LEVELS, MOTIONS):
            v_cmd = motion(drive, name)
            x_cmd = simulator.positions(v_cmd, drive.parameters["T_s"])

            commanded = {"v": v_cmd, "x": x_cmd} if drive.parameters["K_x"] else {"v": v_cmd}
            runs = {
                loop: [_driven(own, v_cmd, level, seed, compensator=block) for seed in SEEDS]
                for loop, (own, block) in loops.items()
            }
            errors = {
                (loop, figure): np.array([_rms(run[figure] - target) for run in every])
                for loop, every in runs.items()
                for figure, target in commanded.items()
            }
            for loop, figure in product(("learned", "plain"), commanded):
                ratio = float(np.median(errors["tuned", figure] / errors[loop, figure]))
                found.setdefault(f"{figure} over {loop}", []).append(ratio)
    row = {"drive": drive.name, "Ms": round(document["tuning"]["Ms"]["after"], 3)}
    for key, every in found.items():
        row[key] = round(statistics.geometric_mean(every), 3)
        row |= {f"{key}, worst": round(max(every), 3)}
        row |= {f"{key}, {n}": round(x, 3) for n, x in zip(MOTIONS, every, strict=False)}
    return row


def _exported_if(folder: Path, to: Path) -> ctypes.CDLL | None:
    """Return what was written into a folder, exported and compiled; None where nothing was."""
    return exported(folder, to) if any(folder.glob("*.fmu")) else None


def _driven(
    drive: Drive, v_cmd: np.ndarray, level: float, seed: int, *, compensator: ctypes.CDLL | None
) -> dict[str, np.ndarray]:
    """Return a run of the drive; the seed sets noise, phase of the encoder and place."""
    p, rng = drive.parameters, np.random.default_rng([seed, drive.seed])
    friction = {name: level * p[name] for name in ("F_c", "F_s")}
    place = {"phase": rng.uniform(), "origin": p["period"] * rng.uniform()}
    # The integral holds at first what the block of the force of position does not.
    held = {"held": p.get("held", 0.0) - (compensator.held if compensator else 0.0)}
    noise, values = (ENCODER_NOISE, drive.noise_F), {**p, **friction, **place, **held}
    return simulator.run(drive.law, values, v_cmd, noise=noise, seed=seed, compensator=compensator)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def exported(learned: Path, folder: Path) -> ctypes.CDLL:
    """Return what was written, exported as C and compiled.

    Raises subprocess.CalledProcessError when it cannot be exported.
    """
    file = next(learned / one for one in ("tuned.json", "learned.json") if (learned / one).exists())
    options = ["--parameters", str(file), "--out", str(folder)]
    subprocess.run([STICKSLIP, "export", "deploy", *options], check=True, capture_output=True)
    files = {path.name: path.read_text(encoding="utf-8") for path in folder.glob("*.[ch]")}
    library = ctypes.CDLL(str(shared_library("added", files | {"glue.c": GLUE}, flags=["-lm"])))
    terms = json.loads(file.read_text(encoding="utf-8")).get("position_force", {})
    at_0 = ("F_0", "g_c", *(f"cogging_c[{k}]" for k in (1, 2, 3)))
    # force of position where the encoder shows 0 [N]
    library.held = sum(terms[one]["value"] for one in at_0 if one in terms)
    if not (folder / "position_force.c").exists():
        library.held = 0.0
    return library


def evaluated(drive: Drive, learned: Path, said: str = "") -> dict[str, Any]:
    """Return the row of a drive: what was written, ratios, predicted ratios, intervals.

    ``learned`` is the folder that ``stickslip learn`` wrote, if it wrote one, and ``said`` what it
    printed on standard error, for a drive of which nothing was learned.
    """
    p, path = drive.parameters, learned / "learned.json"
    row: dict[str, Any] = {
        "drive": drive.name,
        "law": drive.law,
        "motion": "rotary" if drive.rotary else "linear",
        "controller": drive.controller,
        "steps": round(drive.deflection / p["encoder"], 1),
    }
    if not path.exists():
        lines = [line for line in said.splitlines() if "error:" in line] or said.splitlines()
        return row | {"written": "", "why": lines[-1] if lines else "no learned.json"}
    document = json.loads(path.read_text(encoding="utf-8"))
    names = [name for name in PARTS if (learned / f"{name}.fmu").exists()]
    row |= {"written": "", "why": str(document.get("refusal", "")).partition("\n")[0]}
    if names:
        with tempfile.TemporaryDirectory() as folder:
            try:
                compensator = exported(learned, Path(folder))
            except subprocess.CalledProcessError as error:
                return row | {"why": f"not exported: {error.stderr}"}
            by_level = {level: ratios(drive, level, compensator) for level in LEVELS}
        row |= _written(document, names) | _measured(by_level)
        row |= _predictions(drive, document, by_level[1.0])
    return row | _intervals(document, drive)


def _written(document: Mapping[str, Any], names: Sequence[str]) -> dict[str, Any]:
    compared = document.get("compared", {})
    chosen = compared.get("chosen", document.get("compensation", names[0]))
    chosen = names[0] if len(names) == 1 and chosen == "none" else chosen
    shares = {one["compensator"]: one.get("share") for one in compared.get("compensators", ())}
    share = shares.get(chosen) or 1.0
    return {"written": chosen, "share": round(share, 3), "why": ""}


def _measured(by_level: Mapping[float, Mapping[str, float]]) -> dict[str, float]:
    found = {**by_level[1.0], "mean": statistics.geometric_mean(by_level[1.0].values())}
    found |= {
        "worst" if level == 1.0 else f"worst_{level:g}": max(each.values())
        for level, each in by_level.items()
    }
    return {name: round(ratio, 4) for name, ratio in found.items()}


def _predictions(
    drive: Drive, document: Mapping[str, Any], true: Mapping[str, float]
) -> dict[str, Any]:
    """Return the predicted ratios, and how many intervals hold the true ones."""
    rows = [
        one
        for one in document.get("predicted_error", [])
        if one["friction"] == 1.0 and one["figure"] == "velocity"
    ]
    if not rows:
        return {}
    named = {one["motion"]: one for one in rows}
    steady = [one for one in rows if one["motion"] not in PREDICTED.values()]

    def like(name: str) -> dict[str, Any]:
        if name in PREDICTED:
            return named[PREDICTED[name]]
        speed = np.max(motion(drive, name))
        return min(steady, key=lambda one: abs(math.log(one["speed"] / speed)))

    found = {name: like(name) for name in MOTIONS}
    held = [one["low"] <= true[name] <= one["high"] for name, one in found.items()]
    predicted = {f"predicted_{name}": round(one["ratio"], 4) for name, one in found.items()}
    return predicted | {"held": sum(held)}


def _intervals(document: Mapping[str, Any], drive: Drive) -> dict[str, str]:
    truth, shown = drive.truth, document.get("position_force", {})
    found = {"spurious": " ".join(shown.keys() - {"F_0", "F_c", *drive.position_force})}
    held = drive.position_force if drive.axis != "horizontal" else {}
    for name, value in held.items():
        entry = shown.get(name) or (name == "F_0" and document["friction_curve"]["offset"])
        hit = entry and entry["low"] <= value <= entry["high"]
        found[f"interval_{name}"] = "hit" if hit else "miss" if entry else "not reported"
    for name in INTERVALS:
        entry = document.get("parameters", {}).get(name, {})
        found[f"interval_{name}"] = "not reported"
        if name not in truth:
            found[f"interval_{name}"] = "no truth"
        elif "low" in entry and entry.get("identifiability") != "not identifiable":
            hit = entry["low"] <= truth[name] <= entry["high"]
            found[f"interval_{name}"] = "hit" if hit else "miss"
    return found
