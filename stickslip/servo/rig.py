"""The test bench of a drive: it takes commands and returns measurements.

Identification and learning get a rig, never the drive's parameters or its true motion.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stickslip import cosim
from stickslip.catalog.parameters import estimated, friction_law
from stickslip.fmi.process import temporary_folder
from stickslip.ga import SimulatedCost
from stickslip.servo.datasheet import LOOP, Datasheet
from stickslip.servo.measurement import Array
from stickslip.servo.systems import Changes, Feed, build_fmus, paper_loop, servo_loop
from stickslip.servo.velocity_loop import VelocityLoop

MEASURED = ("drive.x_enc", "drive.F_m")


@dataclass(frozen=True)
class Log:
    """One recording, a value each sample.

    Attributes
    ----------
    t : (n,) [s]
    x_enc : (n,) position shown by the encoder [m]
    F_m : (n,) motor force, from the current [N]
    """

    t: Array
    x_enc: Array
    F_m: Array


class Rig:
    """A drive FMU on its test bench.

    Parameters
    ----------
    fmus : folder with drive.fmu and the FMUs of the loop
    datasheet : what is known of it
    T_s : sample period of commands and logs [s]
    law : friction law of the compensator, with which the FMUs were built
    """

    def __init__(self, fmus: Path, datasheet: Datasheet, T_s: float, law: str = "lugre") -> None:
        self.fmus = fmus
        self.datasheet = datasheet
        self.T_s = T_s
        self.law = friction_law(law)

    def push(self, force: Array) -> Log:
        """Command a force (n,) [N], one value a sample, without any loop."""
        system = cosim.System("bench")
        system.add("drive", self.fmus / "drive.fmu")
        system.expose("u", "drive.u")
        return self._record(system, {"u": force})

    def follow(self, v_cmd: Array, loop: VelocityLoop) -> Log:
        """Command a velocity (n,) [m/s], one value a sample, in a velocity loop."""
        return self._record(servo_loop(self.fmus, loop), loop.commands(v_cmd))

    def cost_of(
        self,
        v_cmd: Array,
        loop: VelocityLoop,
        cost: Callable[[cosim.Result], float],
        feed: Feed = "nominal",
        fixed: Mapping[str, float] | None = None,
        *,
        compensated: bool = True,
    ) -> SimulatedCost:
        """Return the cost function of a compensator on the drive: Fig. 3.

        Parameters
        ----------
        v_cmd : (n,) training command, one value a sample [m/s]
        cost : evaluates the recorded ``drive.x_enc`` and ``nominal.v_r``
        fixed : parameters of the compensator that no candidate has
        compensated : whether the compensator's force reaches the drive
        """
        specification = cosim.Specification(
            paper_loop(self.fmus, loop, (fixed or {}) if compensated else None, feed),
            step=self.T_s,
            stop=(len(v_cmd) - 1) * self.T_s,
            record=("drive.x_enc", "nominal.v_r"),
        )
        names = [f"compensator.{name}" for name in estimated(self.law)]
        return SimulatedCost(specification, names, cost, loop.commands(v_cmd))

    def samples(self, duration: float) -> Array:
        """Return the sample instants (n,) of a recording [s]."""
        return np.asarray(np.arange(round(duration / self.T_s) + 1) * self.T_s)

    def _record(self, system: cosim.System, commands: Mapping[str, Array]) -> Log:
        stop = (len(next(iter(commands.values()))) - 1) * self.T_s
        with system.prepare(step=self.T_s, stop=stop, record=MEASURED) as simulation:
            result = simulation.run(inputs=commands)
        return Log(result.time, *(result[measured] for measured in MEASURED))


@contextmanager
def rig_of(truth: Changes, law: str = "lugre") -> Iterator[Rig]:
    """Build a drive with these parameters on its test bench; its files are removed afterwards.

    ``law`` is the friction law of the compensator.
    """
    with temporary_folder() as fmus:
        build_fmus(fmus, truth, law)
        yield Rig(fmus, Datasheet(), LOOP.T_s, law)
