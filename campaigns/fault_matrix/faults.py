"""Faults of logs: each is an experiment, a change of its log, and of what its owner states."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pandas as pd
from scipy.signal import lfilter

from campaigns.fault_matrix.drives import SOUND, Experiment
from stickslip.logs import Description

Log = pd.DataFrame
Damage = Callable[[Log, Description, np.random.Generator], tuple[Log, Description]]
COLUMNS = ("time", "position", "force", "velocity_command")


@dataclass(frozen=True)
class Fault:
    """A fault of a log."""

    damage: Damage = lambda log, known, _: (log, known)  # changes log and description
    experiment: Experiment = SOUND  # that is recorded
    columns: tuple[str, ...] = COLUMNS  # that the log has
    gains: bool | None = True  # whether the owner gives the controller's gains; None tries both

    def applied(
        self, log: Log, known: Description, rng: np.random.Generator
    ) -> tuple[Log, Description]:
        """Return the faulty log and its description."""
        log, known = self.damage(log, known, rng)
        log = log[[*self.columns]]
        known = replace(known, columns={name: known.columns[name] for name in self.columns})
        return log, known if self.gains else replace(known, controller="none", gains={})


def _with(**changes: float | Callable[[np.ndarray], np.ndarray]) -> Damage:
    """Change columns by factors or functions."""

    def damage(log: Log, known: Description, _: np.random.Generator) -> tuple[Log, Description]:
        new = {
            name: change(log[name].to_numpy()) if callable(change) else change * log[name]
            for name, change in changes.items()
        }
        return log.assign(**new), known

    return damage


def _gains(**factors: float) -> Damage:
    def damage(log: Log, known: Description, _: np.random.Generator) -> tuple[Log, Description]:
        gains = {name: factors.get(name, 1.0) * value for name, value in known.gains.items()}
        return log, replace(known, gains=gains)

    return damage


def _late(log: Log, known: Description, _: np.random.Generator, delay: float):
    n = round(delay / (log["time"][1] - log["time"][0]))
    return log.assign(force=log["force"].shift(n).ffill().bfill()), known


def _lost(log: Log, known: Description, rng: np.random.Generator) -> tuple[Log, Description]:
    kept = log[rng.random(len(log)) > 0.02].reset_index(drop=True)
    return kept.assign(time=log["time"][: len(kept)]), known


def _slow(log: Log, known: Description, _: np.random.Generator) -> tuple[Log, Description]:
    every = round(1e-2 / (log["time"][1] - log["time"][0]))
    return log.iloc[::every].reset_index(drop=True), known


def _filtered(x: np.ndarray) -> np.ndarray:
    return np.asarray(lfilter([0.05], [1.0, -0.95], x, zi=[0.95 * x[0]])[0])


def _clipped(x: np.ndarray) -> np.ndarray:
    limit = float(np.quantile(np.abs(x), 0.88))
    return np.clip(x, -limit, limit)


def _with_velocity(factor: float) -> Damage:
    def damage(log: Log, known: Description, _: np.random.Generator) -> tuple[Log, Description]:
        velocity = factor * np.gradient(log["position"], log["time"])
        columns = {**known.columns, "velocity": replace(known.column("force"), name="velocity")}
        return log.assign(velocity=velocity), replace(known, columns=columns)

    return damage


SATURATED = Experiment(limit=0.88)
VELOCITY = (*COLUMNS, "velocity")
FORCE = ("time", "position", "force")
FAULTS: dict[str, Fault] = {
    "none": Fault(gains=None),
    "the drive saturates": Fault(experiment=SATURATED, gains=None),
    "force clipped in the log": Fault(_with(force=_clipped), gains=None),
    "force logged before clipping": Fault(
        lambda log, known, _: (log.assign(force=log["force_command"]), known), SATURATED, gains=None
    ),
    "force 5 ms late": Fault(partial(_late, delay=5e-3), gains=None),
    "force 5 ms early": Fault(partial(_late, delay=-5e-3), gains=None),
    "force 1.5 ms late": Fault(partial(_late, delay=1.5e-3), gains=None),
    "2 % of rows lost": Fault(_lost, gains=None),
    "position in mm read as m": Fault(_with(position=1e3), gains=None),
    "mm and A read as m and N": Fault(_with(position=1e3, force=0.05), columns=FORCE, gains=False),
    "time in ms read as s": Fault(_with(time=1e3), gains=None),
    "command x 1000": Fault(_with(velocity_command=1e3), gains=None),
    "velocity x 1.3": Fault(_with_velocity(1.3), columns=VELOCITY),
    "velocity x 1000": Fault(_with_velocity(1e3), columns=VELOCITY),
    "force x 0.3": Fault(_with(force=0.3)),
    "force inverted": Fault(_with(force=-1.0), gains=None),
    "force in steps of 2.2 N": Fault(_with(force=lambda x: 2.2 * np.round(x / 2.2)), gains=None),
    "force filtered at 16 Hz": Fault(_with(force=_filtered), gains=None),
    "100 Hz sampling": Fault(_slow, gains=None),
    "gains wrong by 5 %": Fault(_gains(K_p=1.05, K_i=1.05)),
    "gains wrong by 50 %": Fault(_gains(K_p=1.5, K_i=1.5)),
    "P given for PI": Fault(_gains(K_i=0.0)),
    "cascade given as PI": Fault(experiment=Experiment(K_x=20.0)),
    "feedforward not given": Fault(experiment=Experiment(inertia=1.0)),
    "friction drifts by 30 %": Fault(experiment=Experiment(drift=0.3), gains=None),
    "one way only": Fault(experiment=Experiment(one_way=True), gains=None),
}


def cases(names: list[str]) -> list[tuple[str, Fault]]:
    """Return the faults of these names with and without gains, each with its own name."""
    found = []
    for name in names:
        fault = FAULTS[name]
        if fault.gains is not False:
            found.append((name, replace(fault, gains=True)))
        if fault.gains is not True:
            found.append((f"{name}, no gains", replace(fault, gains=False)))
    return found
