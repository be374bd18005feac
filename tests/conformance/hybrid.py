"""A mass on contacts with modes: which holds, and what moves in each.

Written from the equations in the README files of the laws, without their C: the velocity has one
sign between events, each change of its sign is an event, and the force of an element that sticks is
compared with its limit in the direction of the motion.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

Array = np.ndarray
Modes = tuple[float, ...]


class Point(NamedTuple):
    """Velocity, driving force and the law's states, in motion of direction ``s`` (0: at rest)."""

    v: float
    u: float
    y: Array
    modes: Modes = ()
    s: float = 0.0


class CoulombStribeck:
    """Static friction at rest, the Stribeck curve in motion."""

    scales: tuple[float, ...] = ()

    def __init__(self, p: Mapping[str, Any]) -> None:
        self.p = p

    def g(self, v: float) -> float:
        p = self.p
        return p["F_c"] + (p["F_s"] - p["F_c"]) * np.exp(-((abs(v) / p["v_s"]) ** p["delta"]))

    def direction(self, at: Point) -> float:
        """Return where a mass at v = 0 begins to go: 1, -1, or 0 for rest."""
        return 0.0 if abs(at.u) <= self.p["F_s"] else np.sign(at.u)

    def modes(self, at: Point) -> Modes:
        """Return the modes in which the motion goes on; ``at`` has those before."""
        return (at.s,)

    def flow(self, at: Point) -> tuple[float, Array]:
        """Return the friction force and the derivatives of the law's states."""
        return (at.s * self.g(at.v) if at.s else at.u), np.empty(0)


class Gms(CoulombStribeck):
    """Elements that stick as springs, and slip towards their share of the Stribeck curve."""

    scales = (1.0,) * 4

    def __init__(self, p: Mapping[str, Any]) -> None:
        super().__init__(p)
        alpha, kappa = (np.array([p[f"{n}[{k}]"] for k in range(1, 5)]) for n in ("alpha", "kappa"))
        self.alpha, self.k = alpha / alpha.sum(), p["sigma_0"] * kappa / kappa.sum()

    def direction(self, at: Point) -> float:
        return np.sign(at.u - at.y.sum())

    def modes(self, at: Point) -> Modes:
        slipped = np.array(at.modes) == at.s
        full = at.s * at.y >= self.alpha * self.g(at.v) * (1.0 - 1e-10)
        return tuple(np.where(slipped & (at.s != 0.0) | full, at.s, 0.0))

    def flow(self, at: Point) -> tuple[float, Array]:
        attracted = self.p["C"] * (self.alpha * at.s - at.y / self.g(at.v))
        rate = np.where(np.array(at.modes) != 0.0, attracted, self.k * at.v)
        return at.y.sum() + self.p["sigma_1"] / self.p["sigma_0"] * rate.sum(), rate


class Leuven(CoulombStribeck):
    """Bristles with elements that slip at forces of their own, all but the last."""

    scales = (1e-6,) * 4

    def __init__(self, p: Mapping[str, Any]) -> None:
        super().__init__(p)
        kappa = np.array([p[f"kappa[{k}]"] for k in range(1, 5)])
        self.k = p["sigma_0"] * kappa / kappa.sum()
        self.limit = p["F_c"] * np.array([p[f"W[{k}]"] for k in range(1, 4)]) / self.k[:3]

    def share(self, at: Point) -> float:
        return at.s * float(self.k @ at.y) / self.g(at.v)

    def direction(self, at: Point) -> float:
        return np.sign(at.u - self.k @ at.y)

    def going(self, at: Point) -> float:
        """Return the sign of dz/dt."""
        return at.s * np.sign(1.0 - self.share(at))

    def modes(self, at: Point) -> Modes:
        going = self.going(at)
        return tuple(np.where(going * at.y[:3] >= self.limit * (1.0 - 1e-9), going, 0.0))

    def flow(self, at: Point) -> tuple[float, Array]:
        share = self.share(at)
        dz = at.v * (1.0 - np.sign(share) * abs(share) ** self.p["n_h"])
        rate = np.append(np.where(np.array(at.modes) != 0.0, 0.0, dz), dz)
        return float(self.k @ at.y) + self.p["sigma_1"] * dz, rate


LAWS = {"coulomb_stribeck": CoulombStribeck, "gms": Gms, "leuven": Leuven}
