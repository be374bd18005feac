"""Faults of logs: each is an experiment, a change of its log, and of what its owner states."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from scipy.signal import lfilter

from campaigns.fault_matrix.drives import SOUND, Experiment
from stickslip.logs import Column, Description

Log = pd.DataFrame
Damage = Callable[[Log, np.random.Generator], Log]
COLUMNS = ("time", "position", "force", "velocity_command")


@dataclass(frozen=True)
class Fault:
    """A fault of a log."""

    damage: Damage = lambda log, _: log  # changes the log
    experiment: Experiment = SOUND  # that is recorded
    columns: tuple[str, ...] = COLUMNS  # that the log has
    gains: bool | None = True  # whether the owner gives the controller's gains; None tries both
    factor: dict[str, float] | None = None  # of gains that are given wrong, by name

    def applied(
        self, log: Log, known: Description, rng: np.random.Generator
    ) -> tuple[Log, Description]:
        """Return the faulty log and its description."""
        log = self.damage(log, rng)[[*self.columns]]
        gains = {name: (self.factor or {}).get(name, 1.0) * x for name, x in known.gains.items()}
        known = replace(known, columns={name: Column(name) for name in self.columns}, gains=gains)
        return log, known if self.gains else replace(known, controller="none", gains={})


def _with(**changes: float | Callable[[np.ndarray], np.ndarray]) -> Damage:
    """Change columns by factors or functions."""
    return lambda log, _: log.assign(
        **{
            name: change(log[name].to_numpy()) if callable(change) else change * log[name]
            for name, change in changes.items()
        }
    )


def _period(log: Log) -> float:
    return log["time"][1] - log["time"][0]


def _late(delay: float) -> Damage:
    return lambda log, _: log.assign(
        force=log["force"].shift(round(delay / _period(log))).ffill().bfill()
    )


def _lost(log: Log, rng: np.random.Generator) -> Log:
    kept = log[rng.random(len(log)) > 0.02].reset_index(drop=True)
    return kept.assign(time=log["time"][: len(kept)])


def _slow(log: Log, _: np.random.Generator) -> Log:
    return log.iloc[:: round(1e-2 / _period(log))].reset_index(drop=True)


def _filtered(x: np.ndarray) -> np.ndarray:
    return np.asarray(lfilter([0.05], [1.0, -0.95], x, zi=[0.95 * x[0]])[0])


def _clipped(x: np.ndarray) -> np.ndarray:
    limit = float(np.quantile(np.abs(x), 0.88))
    return np.clip(x, -limit, limit)


def _with_velocity(factor: float) -> Damage:
    return lambda log, _: log.assign(velocity=factor * np.gradient(log["position"], log["time"]))


SATURATED = Experiment(limit=0.88)
VELOCITY = (*COLUMNS, "velocity")
FORCE = ("time", "position", "force")
FAULTS: dict[str, Fault] = {
    "none": Fault(gains=None),
    "the drive saturates": Fault(experiment=SATURATED, gains=None),
    "force clipped in the log": Fault(_with(force=_clipped), gains=None),
    "force logged before clipping": Fault(
        lambda log, _: log.assign(force=log["force_command"]), SATURATED, gains=None
    ),
    "force 5 ms late": Fault(_late(5e-3), gains=None),
    "force 5 ms early": Fault(_late(-5e-3), gains=None),
    "force 1.5 ms late": Fault(_late(1.5e-3), gains=None),
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
    "gains wrong by 5 %": Fault(factor={"K_p": 1.05, "K_i": 1.05}),
    "gains wrong by 50 %": Fault(factor={"K_p": 1.5, "K_i": 1.5}),
    "P given for PI": Fault(factor={"K_i": 0.0}),
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
