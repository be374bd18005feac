"""What ``stickslip learn`` makes of faulty logs: right, flagged, refused, or confident and wrong.

    python -m tests.fault_matrix --drives 10 --seeds 3 --workers 2 --out faults

Drives of every friction law are recorded, each recording is damaged in every way of ``FAULTS``, and
learned. An outcome is *right* when mass, friction curve and compensator agree with the drive,
*flagged* when they do not and a warning names a fault that the sound log does not have, *refused*
when nothing is written, and else *confident and wrong*. matrix.csv is rewritten after each log.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pandas as pd

import stickslip as ss
from stickslip.errors import StickslipError
from stickslip.fmi.process import temporary_folder
from stickslip.logs import Column, Description
from stickslip.pipeline.record_mode import COMMISSIONING, gains_of
from stickslip.planning import plan
from stickslip.servo.datasheet import VALIDATION, Datasheet
from stickslip.servo.systems import Compensator, build_fmus, build_loop, servo_loop
from stickslip.servo.velocity_loop import VelocityLoop, design_velocity_loop

MASS_TOLERANCE = 0.02
FRICTION_TOLERANCE = 0.05
"""Of the largest friction at the speeds visited."""
WORSE = 1.02
OUTCOMES = ("right", "flagged", "refused", "confident and wrong")


@dataclass(frozen=True)
class Drive:
    """A drive by its friction law and the parameters of its FMU that are not Table 2's."""

    law: str = "lugre"
    parameters: dict[str, float | bool] = field(default_factory=dict)

    def friction(self, v: np.ndarray) -> np.ndarray:
        """Return friction at speeds v > 0 [N], without that of asymmetry and position."""
        model = ss.models.load_model("drive", self.law)
        p = {variable.name: variable.start for variable in model.variables} | self.parameters
        if "v_s" not in p:
            return p["F_c"] + p["b"] * v
        return p["F_c"] + (p["F_s"] - p["F_c"]) * np.exp(-((v / p["v_s"]) ** 2)) + p["b"] * v

    @property
    def mass(self) -> float:
        """Moving mass [kg]."""
        return float(self.parameters.get("m", 5.557))


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

Log = pd.DataFrame
Damage = Callable[[Log, Description, np.random.Generator], tuple[Log, Description]]


def _column(name: str, change: Callable[[np.ndarray], np.ndarray]) -> Damage:
    def damage(log: Log, known: Description, _: np.random.Generator) -> tuple[Log, Description]:
        return log.assign(**{name: change(log[name].to_numpy())}), known

    return damage


def _gains(factor: float) -> Damage:
    def damage(log: Log, known: Description, _: np.random.Generator) -> tuple[Log, Description]:
        gains = {k: v * factor if k in ("K_p", "K_i") else v for k, v in known.gains.items()}
        return log, replace(known, gains=gains)

    return damage


def _late(log: Log, known: Description, _: np.random.Generator) -> tuple[Log, Description]:
    n = round(5e-3 / (log["time"][1] - log["time"][0]))
    force = np.concatenate((np.full(n, log["force"][0]), log["force"][:-n]))
    return log.assign(force=force), known


def _lost(log: Log, known: Description, rng: np.random.Generator) -> tuple[Log, Description]:
    kept = log[rng.random(len(log)) > 0.02].reset_index(drop=True)
    return kept.assign(time=log["time"][: len(kept)]), known


def _slow(log: Log, known: Description, _: np.random.Generator) -> tuple[Log, Description]:
    every = round(1e-2 / (log["time"][1] - log["time"][0]))
    return log.iloc[::every].reset_index(drop=True), replace(known, controller="none", gains={})


def _filtered(x: np.ndarray) -> np.ndarray:
    share, y = 0.05, np.empty_like(x)
    level = x[0]
    for i, value in enumerate(x):
        level += share * (value - level)
        y[i] = level
    return y


def _saturated(x: np.ndarray) -> np.ndarray:
    limit = float(np.quantile(np.abs(x), 0.88))
    return np.clip(x, -limit, limit)


def _other(log: Log, known: Description, _: np.random.Generator) -> tuple[Log, Description]:
    gains = {"K_p": known.gains["K_p"], "K_i": 0.0} | {"T_s": known.gains["T_s"]}
    return log, replace(known, gains=gains)


def _sound(log: Log, known: Description, _: np.random.Generator) -> tuple[Log, Description]:
    return log, known


FAULTS: dict[str, Damage] = {
    "none": _sound,
    "force clipped in the log": _column("force", _saturated),
    "force 5 ms late": _late,
    "2 % of rows lost": _lost,
    "position in mm read as m": _column("position", lambda x: 1e3 * x),
    "force x 0.3": _column("force", lambda x: 0.3 * x),
    "force inverted": _column("force", lambda x: -x),
    "command x 1000": _column("velocity_command", lambda x: 1e3 * x),
    "time in ms read as s": _column("time", lambda t: 1e3 * t),
    "force in steps of 2 N": _column("force", lambda x: 2.0 * np.round(x / 2.0)),
    "force filtered at 16 Hz": _column("force", _filtered),
    "100 Hz sampling": _slow,
    "gains wrong by 5 %": _gains(1.05),
    "gains wrong by 50 %": _gains(1.5),
    "another controller": _other,
    "friction drifts by 30 %": _sound,
    "one way only": _sound,
}
"""Those of the drive or of the experiment, the last two, are made when it is recorded."""


def main() -> None:
    """Record, damage, learn, count."""
    parser = argparse.ArgumentParser(prog="python -m tests.fault_matrix", description=__doc__)
    parser.add_argument("--drives", type=int, default=len(DRIVES), metavar="N")
    parser.add_argument("--faults", nargs="+", choices=FAULTS, default=list(FAULTS))
    parser.add_argument("--seeds", type=int, default=3, metavar="N")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    parser.add_argument("--out", type=Path, default=Path("faults"), metavar="DIR")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    names = list(DRIVES)[: options.drives]
    cells = [(name, seed) for seed in range(options.seeds) for name in names]
    rows: list[dict[str, object]] = []
    with ProcessPoolExecutor(options.workers, mp_context=get_context("spawn")) as pool:
        for found in pool.map(partial(learn_all, tuple(options.faults)), *zip(*cells, strict=True)):
            rows += found
            pd.DataFrame(rows).to_csv(options.out / "matrix.csv", index=False, lineterminator="\n")
            for row in found:
                print(
                    f"{row['drive']:18} {row['fault']:26} {row['outcome']:20} {row['why']}",
                    flush=True,
                )
    table = pd.DataFrame(rows)
    count = pd.crosstab(table["fault"], table["outcome"]).reindex(columns=OUTCOMES, fill_value=0)
    print("\n" + count.reindex([f for f in FAULTS if f in count.index]).to_string())


def learn_all(faults: tuple[str, ...], name: str, seed: int) -> list[dict[str, object]]:
    """Return a row for each fault in a recording of one drive; the sound log comes first."""
    drive, rows = DRIVES[name], []
    known: frozenset[str] = frozenset()
    with temporary_folder() as folder:
        build_fmus(folder, {"law": drive.law, **drive.parameters})
        for fault in ("none", *(f for f in faults if f != "none")):
            rng = np.random.default_rng([seed, list(FAULTS).index(fault)])
            log, description = FAULTS[fault](*record(folder, drive, fault, seed), rng)
            path = folder / "log.csv"
            log.to_csv(path, index=False)
            outcome, why, remarks = learn_one(folder, drive, path, description, known)
            known = known or remarks
            rows.append(
                {"drive": name, "law": drive.law, "seed": seed, "fault": fault}
                | {"outcome": outcome, "why": why}
            )
    return rows


def learn_one(
    fmus: Path, drive: Drive, path: Path, description: Description, known: frozenset[str]
) -> tuple[str, str, frozenset[str]]:
    """Return outcome, its reason, and the remarks of one log."""
    try:
        learned = ss.learn(path, description)
    except StickslipError as error:
        return "refused", str(error).splitlines()[0][:200], frozenset()
    if learned.refusal:
        return "refused", learned.refusal[:200], frozenset()
    findings = (*learned.findings, *learned.estimation.faults)
    remarks = frozenset(finding.what for finding in findings if finding.severity != "note")
    wrong = "; ".join(_wrong(fmus, drive, learned))
    if not wrong:
        return "right", "", remarks
    new = remarks - known
    outcome = "flagged" if new or (not known and remarks) else "confident and wrong"
    return outcome, f"{wrong} ({' | '.join(sorted(new))})"[:300], remarks


def _wrong(fmus: Path, drive: Drive, learned) -> Iterator[str]:
    estimation = learned.estimation
    m = estimation.known.get("m")
    if m is not None:
        off = m.value / drive.mass - 1.0
        if abs(off) > MASS_TOLERANCE and not m.low <= drive.mass <= m.high:
            yield f"m {off:+.1%} [{m.low / drive.mass - 1:+.1%}, {m.high / drive.mass - 1:+.1%}]"
    values = estimation.compensator
    v = np.quantile(np.abs(estimation.figures.velocity_recorded), (0.5, 0.75, 0.95))
    truth = drive.friction(v)
    rise = (values["F_s"] - values["F_c"]) * np.exp(-((v / values["v_s"]) ** values["delta"]))
    found = values["F_c"] + rise + estimation.known["b"].value * v
    off = float(np.max(np.abs(found - truth)) / np.max(truth))
    if off > FRICTION_TOLERANCE:
        yield f"F(v) off by {off:.0%}"
    yield from _worse(fmus, drive, values)


def _worse(fmus: Path, drive: Drive, values: dict[str, float]) -> Iterator[str]:
    loop = _loop(drive.mass)
    for speed in (1.0, 0.1, 0.01):
        command = replace(
            VALIDATION, height=speed * VALIDATION.height, slope=speed * VALIDATION.slope
        )
        v_cmd = command.sample(np.arange(round(command.corners()[-1] / loop.T_s) + 1) * loop.T_s)
        errors = []
        for chain in ([], [Compensator("compensator", "compensator", values)]):
            system = build_loop(fmus, loop, chain)
            stop = (len(v_cmd) - 1) * loop.T_s
            with system.prepare(step=loop.T_s, stop=stop, record=("drive.v",)) as simulation:
                v = simulation.run({}, loop.commands(v_cmd))["drive.v"]
            errors.append(math.sqrt(float(np.mean((v - v_cmd) ** 2))))
        if errors[1] > WORSE * errors[0]:
            yield f"{errors[1] / errors[0]:.2f} times the error at {1e3 * command.height:g} mm/s"


def _loop(mass: float) -> VelocityLoop:
    return design_velocity_loop(Datasheet().axis(mass, 0.0), COMMISSIONING)


def record(folder: Path, drive: Drive, fault: str, seed: int) -> tuple[Log, Description]:
    loop = _loop(drive.mass)
    v_cmd = plan()["velocity_command"].to_numpy()
    if fault == "one way only":
        v_cmd = np.abs(v_cmd)
    t = np.arange(len(v_cmd)) * loop.T_s
    noise = {"drive.noise": True, "drive.seed": seed + 1}
    with servo_loop(folder, loop).prepare(
        step=loop.T_s, stop=t[-1], record=("drive.x_enc", "drive.F_m")
    ) as simulation:
        drift = _drift(drive, t) if fault == "friction drifts by 30 %" else None
        result = simulation.run(noise, {"v_cmd": v_cmd}, scenario=drift)
    x, force = result["drive.x_enc"], result["drive.F_m"]
    log = pd.DataFrame({"time": t, "position": x, "force": force, "velocity_command": v_cmd})
    columns = {name: Column(name) for name in log}
    return log, Description(columns=columns, controller="PI", gains=gains_of(loop))


def _drift(drive: Drive, t: np.ndarray) -> ss.Scenario:
    """Return friction that falls by 30 % in steps of 1 %."""
    model = ss.models.load_model("drive", drive.law)
    start = {variable.name: variable.start for variable in model.variables} | drive.parameters
    scenario = ss.Scenario()
    for share in np.arange(0.99, 0.695, -0.01):
        at = float(t[round((1.0 - share) / 0.3 * 0.95 * (len(t) - 1))])
        for name in ("F_c", "F_s"):
            if name in start:
                scenario = scenario.set(f"drive.{name}", share * float(start[name]), at)
    return scenario


if __name__ == "__main__":
    main()
