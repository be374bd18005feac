"""Which phenomena of friction a law shows, computed by running it.

A velocity is imposed on the law in the feedforward compensator, and a force pushes a mass on it in
the stage, both with the start values of ``law.toml``.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from stickslip import cosim, models
from stickslip.servo.measurement import Array

H = 5e-4
"""Step of the runs [s]."""
_F_C = 5.999  # [N] Coulomb friction and [m/s] Stribeck velocity of every law's start values
_V_S = 5.5697e-4


@dataclass(frozen=True)
class Contact:
    """A friction law that runs.

    Attributes
    ----------
    law : name of the law
    folder : with its ``compensator.fmu`` and ``stage.fmu``
    """

    law: str
    folder: Path

    def follow(self, v: Array, step: float = H) -> tuple[Array, Array]:
        """Return the mean force [N] over each step of a held velocity (n,) and at its end."""
        found = self._run("compensator", "v", v, step)
        return found["c.F_mean"][1:], found["c.F_f"][1:]

    def push(self, u: Array, step: float = H) -> tuple[Array, Array]:
        """Return position [m] and friction force [N] of a stage, (n,), under held forces [N]."""
        found = self._run("stage", "u", u, step)
        return found["c.x"][1:], found["c.F_f"][1:]

    def couple(self, force: cosim.Function, stop: float, step: float) -> dict[str, Array]:
        """Return x, v, F_f and the time of a stage that a function pushes, (n,), from its x and v.

        Parameters
        ----------
        force : with the output F [N]; its inputs are outputs of the stage
        stop, step : length of the run and of its steps [s]
        """
        system = cosim.System()
        system.add("c", self.folder / "stage.fmu")
        system.add("f", force)
        system.connect("f.F", "c.u")
        for name in force.inputs:
            system.connect(f"c.{name}", f"f.{name}")
        with system.prepare(step=step, stop=stop) as simulation:
            result = simulation.run()
            found = {name: result[f"c.{name}"].copy() for name in ("x", "v", "F_f")}
            return {"time": result.time.copy(), **found}

    def _run(self, model: str, driven: str, values: Array, step: float) -> dict[str, Array]:
        system = cosim.System()
        system.add("c", self.folder / f"{model}.fmu")
        system.expose(driven, f"c.{driven}")
        with system.prepare(step=step, stop=step * len(values)) as simulation:
            result = simulation.run(inputs={driven: np.append(values, values[-1])})
            return {name: result[name].copy() for name in result.names}


@contextmanager
def contact_of(law: str, **parameters: float) -> Iterator[Contact]:
    """Build the FMUs of a friction law, with parameters where they have them.

    Raises
    ------
    models.UnknownLaw
        When there is no such law.
    """
    with tempfile.TemporaryDirectory() as folder:
        for model in ("compensator", "stage"):
            known = {variable.name for variable in models.load_model(model, law).variables}
            start = {name: value for name, value in parameters.items() if name in known}
            models.build_fmu(model, folder, law=law, start=start)
        yield Contact(law, Path(folder))


def _slow(contact: Contact, ways: list[float]) -> tuple[Array, Array, Array]:
    """Go displacements [m] one after the other at 10 nm/s, too slowly for damping.

    Returns of each step of 1 s the displacement [m], the mean force and that at its end [N].
    """
    steps = np.concatenate([np.full(round(abs(way) / 1e-8), np.sign(way) * 1e-8) for way in ways])
    return steps, *contact.follow(steps, 1.0)


def steady_drop(contact: Contact) -> float:
    """Return how much steady friction falls from 0.2 to 20 mm/s [N]."""
    slow = contact.follow(np.full(12_000, 2e-4))[0][-1]
    return float(slow - contact.follow(np.full(2_000, 0.02))[0][-1])


def presliding(contact: Contact) -> float:
    """Return the displacement [m] that a load of half of F_c leaves after 50 ms."""
    ramp = np.minimum(np.arange(300) / 200.0, 1.0)
    return float(contact.push(0.5 * _F_C * ramp)[0][-1])


def presliding_loss(contact: Contact) -> float:
    """Return the loss [J] of a slow cycle of +-10 um in presliding."""
    steps, force, _ = _slow(contact, [1e-5, *[-2e-5, 2e-5] * 6])
    return float(np.sum((force * steps)[-4000:]))


def open_loop(contact: Contact) -> float:
    """Return the force [N] by which the minor loop 0, 15, 0 um after 0, 40, 0 um stays open."""
    *_, force = _slow(contact, [40e-6, -40e-6, 15e-6, -15e-6])
    return float(abs(force[-1] - force[-3001]))


def lag(contact: Contact) -> float:
    """Return how much more friction [N] there is at 1.5 v_s accelerating than decelerating.

    The velocity is v_s (1.5 + sin(100 t)).
    """
    step, omega = 2e-5, 100.0
    t = (np.arange(round((0.5 + 4 * np.pi / omega) / step)) + 0.5) * step
    wave = np.sin(omega * t)
    force, _ = contact.follow(_V_S * (1.5 + wave), step)
    last = t > t[-1] - 2 * np.pi / omega
    ends = []
    for side in (last & (np.cos(omega * t) > 0), last & (np.cos(omega * t) <= 0)):
        order = np.argsort(wave[side])
        ends.append(float(np.interp(0.0, wave[side][order], force[side][order])))
    return ends[0] - ends[1]


def break_away(contact: Contact, rate: float, dwell: float = 0.0) -> float:
    """Return the largest friction force [N] under a force that rises, after a slide and a rest.

    Parameters
    ----------
    rate : of the force [N/s]
    dwell : time at rest after a slide [s]; without one the contact is new
    """
    slide = np.append(np.full(200, 14.0), np.zeros(400 + round(dwell / H)))
    before = slide if dwell else np.zeros(0)
    ramp = rate * H * np.arange(round(9.5 / rate / H))
    return float(contact.push(np.concatenate([before, ramp]))[1][len(before) :].max())


def drift(contact: Contact) -> float:
    """Return the speed [m/s] at which a load of 2.4 + 1.6 sin(2 pi 5 t) N moves the mass."""
    t = np.arange(8_000) * H
    x, _ = contact.push(2.4 + 1.6 * np.sin(2 * np.pi * 5.0 * t))
    return float(x[-1] - x[-4_001]) / (4_000 * H)


PHENOMENA: dict[str, tuple[str, float, Callable[[Contact], float]]] = {
    "steady friction at 0.2 less 20 mm/s": ("N", 1.0, steady_drop),
    "presliding displacement at F_c/2": ("um", 1e6, presliding),
    "loss of a presliding cycle, +-10 um": ("uJ", 1e6, presliding_loss),
    "minor loop left open": ("N", 1.0, open_loop),
    "lag at 1.5 v_s, 100 rad/s": ("N", 1.0, lag),
    "break-away at 2 N/s": ("N", 1.0, lambda contact: break_away(contact, 2.0)),
    "break-away at 50 N/s": ("N", 1.0, lambda contact: break_away(contact, 50.0)),
    "break-away 10 s less 0.1 s after a slide": (
        "N",
        1.0,
        lambda contact: break_away(contact, 50.0, 10.0) - break_away(contact, 50.0, 0.1),
    ),
    "drift under a load below break-away": ("um/s", 1e6, drift),
}
"""Name -> unit, how many of it an SI unit has, and the function that computes it in SI units."""


def phenomena(*laws: str) -> pd.DataFrame:
    """Return the size of each phenomenon of ``PHENOMENA``, a row each, a column for each law.

    Parameters
    ----------
    laws : names; all by default

    Returns
    -------
    pandas.DataFrame
        indexed by phenomenon and unit

    Raises
    ------
    models.UnknownLaw
        When there is no such law.
    """
    index = pd.MultiIndex.from_tuples([(name, unit) for name, (unit, *_) in PHENOMENA.items()])
    columns = {}
    for law in laws or models.law_names():
        with contact_of(law) as contact:
            columns[law] = [many * compute(contact) for _, many, compute in PHENOMENA.values()]
    return pd.DataFrame(columns, index=index)
