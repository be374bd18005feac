"""Runs of an entrant in the loop around a drive."""

import shutil
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from stickslip import cosim, models
from stickslip.compensators.entrants import Entrant, TunedEntrant
from stickslip.servo.measurement import Array
from stickslip.servo.systems import build_fmus, build_loop, nominal_parameters
from stickslip.servo.velocity_loop import VelocityLoop


def build_entrants(folder: Path, entrants: list[Entrant]) -> None:
    """Build the FMUs of the loop but for the drive, and those of all entrants."""
    for name in ("velocity_controller", "nominal_loop"):
        models.build_fmu(name, folder)
    every = [part for one in entrants for part in one.parts if part.model]
    for part in every:
        if part.experiment and part.law:  # what a rig runs beside the drive
            build_fmus(folder, {}, part.law.name, only=("compensator", "stage"))
    for file, part in {part.file: part for part in every}.items():
        if part.own_fmu is not None:
            shutil.copy(part.own_fmu, folder / f"{file}.fmu")
        else:
            law = part.law.name if part.law else None
            models.build_fmu(part.model, folder, law=law, called=file)


class Course(ExitStack):
    """A loop that is prepared once and run with many values of its entrant's parameters."""

    def __init__(
        self,
        fmus: Path,  # folder with drive.fmu and what ``build_entrants`` builds
        loop: VelocityLoop,  # as designed; an entrant may choose other gains in each run
        entrant: Entrant,
        samples: int,  # of the longest command
        record: cosim.Record | tuple[str, ...],  # signals
    ) -> None:
        super().__init__()
        self.loop, self._n = loop, samples
        system, stop = build_loop(fmus, loop, entrant.chain), (samples - 1) * loop.T_s
        prepared = system.prepare(step=loop.T_s, stop=stop, record=record)
        self._simulation = self.enter_context(prepared)

    def run(
        self, tuned: TunedEntrant, v_cmd: Array, drive: Mapping[str, float] | None = None
    ) -> cosim.Result:
        """Run a command (n,) [m/s], with start values of the drive, such as ``seed``."""
        values = dict(tuned.parameters)
        if tuned.loop is not self.loop:
            values |= {"controller.K_p": tuned.loop.K_p, "controller.K_i": tuned.loop.K_i}
            nominal = nominal_parameters(tuned.loop)
            values |= {f"nominal.{name}": value for name, value in nominal.items()}
            if self.loop.K_x:
                values["controller.K_x"] = tuned.loop.K_x
        values |= {f"controller.{name}": value for name, value in tuned.damping.items()}
        values |= {f"drive.{name}": value for name, value in (drive or {}).items()}
        longer = np.pad(v_cmd, (0, self._n - len(v_cmd)), mode="edge")
        until = (len(v_cmd) - 1) * self.loop.T_s
        return self._simulation.run(values, tuned.loop.commands(longer), until=until)
