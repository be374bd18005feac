"""A drive FMU as a rig."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from stickslip import cosim, ga
from stickslip.catalog.parameters import estimated
from stickslip.fmi.process import temporary_folder
from stickslip.rigs.contract import Command, Log, Rig, TrialLog
from stickslip.rigs.limits import RigLimits
from stickslip.servo.axis import LOOP, Datasheet
from stickslip.servo.measurement import Array
from stickslip.servo.systems import CONTROL, Changes, build_fmus, paper_loop, servo_loop
from stickslip.servo.velocity_loop import VelocityLoop

MEASURED = ("drive.x_enc", "drive.F_m")


class FmuRig(Rig):
    """A drive FMU on its test bench; each motion begins with a new drive.

    Compensators run as FMUs beside it, so that candidates can be tried side by side.

    Parameters
    ----------
    fmus : folder with drive.fmu, stage.fmu and the FMUs of the loop
    datasheet : what is known of it
    T_s : sample period of commands and logs [s]
    law : friction law of the compensator, with which the FMUs were built
    limits : that a motion must keep; checked when it has been simulated
    """

    name = "drive.fmu"

    def __init__(
        self,
        fmus: Path | str,
        datasheet: Datasheet,
        T_s: float,
        law: str = "lugre",
        limits: RigLimits | None = None,
    ) -> None:
        super().__init__(datasheet, T_s, limits, law)
        self.fmus = Path(fmus)

    def move(self, command: Command) -> Log:
        """Simulate a motion."""
        if command.force is None:
            system = servo_loop(self.fmus, command.loop)
            if command.added_force is not None:
                system.expose("F_ff", "controller.F_ff")
        else:
            system = cosim.System("bench")
            system.add("drive", self.fmus / "drive.fmu")
            system.expose("F", "drive.u")
        stop = (len(command) - 1) * self.T_s
        with system.prepare(step=self.T_s, stop=stop, record=MEASURED) as simulation:
            result = simulation.run(inputs=command.signals)
        return Log(result.time, *(result[measured] for measured in MEASURED))

    def cost_of(
        self, v_cmd: Array, loop: VelocityLoop, cost: Callable[[TrialLog], float]
    ) -> ga.SimulatedCost:
        """Return the cost of a compensator on a velocity command (n,) [m/s], without limits.

        Its argument are the parameters (k,) in the order of the law; ``cost`` evaluates the
        recorded ``drive.x_enc`` and ``nominal.v_r``. It pickles, and its runs go side by side.
        """
        names = [f"compensator.{name}" for name in estimated(self.law)]
        whole = self._simulated(v_cmd, loop, compensated=True)
        return ga.SimulatedCost(whole, names, cost, loop.commands(v_cmd))

    def _simulated(
        self, v_cmd: Array, loop: VelocityLoop, *, compensated: bool
    ) -> cosim.Specification:
        return cosim.Specification(
            paper_loop(self.fmus, loop, {} if compensated else None),
            step=self.T_s,
            stop=(len(v_cmd) - 1) * self.T_s,
            record=("drive.x_enc", "nominal.v_r"),
        )


@contextmanager
def rig_of(truth: Changes, law: str = "lugre") -> Iterator[FmuRig]:
    """Build a drive on its bench, for a compensator of a law, and remove its files afterwards."""
    with temporary_folder() as fmus:
        build_fmus(fmus, truth, law, ("drive", "compensator", "stage", *CONTROL))
        yield FmuRig(fmus, Datasheet(), LOOP.T_s, law)
