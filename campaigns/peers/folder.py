"""A data set as all tools read it: a folder with set.json, train.csv and held.csv."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Run:
    """A run in the loop u = K_p (K_x (x_cmd - x) - v), |u| <= u_max; rotary: rad for m."""

    t: Array  # (n,) even, from 0 on [s]
    x: Array  # (n,) position as the encoder shows it [m]
    F: Array  # (n,) force of the motor as measured [N]
    x_cmd: Array  # (n,) [m]
    K_x: float  # [1/s]
    K_p: float  # [N s/m]
    u_max: float  # [N]

    @property
    def v(self) -> Array:
        """Velocity (n,) [m/s]: differences over 20 ms, at the ends over 10 ms."""
        n, k = round(0.01 / self.t[1]), np.arange(len(self.t))
        first, last = np.maximum(k - n, 0), np.minimum(k + n, k[-1])
        return np.asarray((self.x[last] - self.x[first]) / (self.t[last] - self.t[first]))

    def errors(self, x: Array, F: Array) -> dict[str, float]:
        """Return the RMS errors of a simulated run: position [m], force relative to its RMS."""
        left = [float(np.sqrt(np.mean(one**2))) for one in (x - self.x, F - self.F, self.F)]
        return {"position": left[0], "force": left[1] / left[2]}


def facts(folder: Path) -> dict[str, Any]:
    """Return what every tool is told, and ``truth``, of which none is told."""
    return dict(json.loads((folder / "set.json").read_text(encoding="utf-8")))


def read(folder: Path, name: str) -> Run:
    """Return the run ``train`` or ``held``."""
    signals = np.loadtxt(folder / f"{name}.csv", delimiter=",", skiprows=1).T
    return Run(*signals, **facts(folder)["loops"][name])


def bob(known: dict[str, Any]) -> tuple[float, float, float]:
    """Return mass, distance from the joint and inertia about it of the load, which are known."""
    m, arm, length = known["load"]
    com = (m + arm / 2) * length / (m + arm) if m else 0.0
    return m + arm, com, (m + arm / 3) * length**2
