"""A system as the application gives it: with components of other kinds, and many runs."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

from stickslip.cosim.system import system
from stickslip.keywords import RunOptions, SearchOptions, SweepOptions, named

if TYPE_CHECKING:
    import pandas as pd

    from stickslip.cosim import DefaultExperiment, Result
    from stickslip.cosim.component import Interface
    from stickslip.cosim.signals.tables import Inputs
    from stickslip.figures import Figure
    from stickslip.servo.systems import Compensator
    from stickslip.servo.velocity_loop import VelocityLoop
    from stickslip.sweeping import Optimum


class System(system.System):
    """Components coupled from outputs to inputs. Variables are named ``component.variable``.

    Its attributes are those of ``cosim.System``.
    """

    @classmethod
    def of(cls, system: system.System) -> System:
        """Return the same components and connections as such a system."""
        found = cls(system.name)
        vars(found).update(vars(system))
        return found

    def add(
        self,
        name: str,
        fmu: object,
        parameters: Mapping[str, object] | None = None,
        *,
        interface: Interface | None = None,
    ) -> None:
        """Add a component, with start values by variable name.

        Parameters
        ----------
        fmu : an FMU or its path, a block of ``ss.blocks``, a linear system of python-control, or a
            Python function of the inputs that its parameters name
        interface : by which an FMU is run: ``co_simulation``, the default where it has one, or
            ``model_exchange``

        Raises
        ------
        FmuError, ConnectionFault, ParameterError
            When it is no component, its name is taken, or a start value does not fit.
        LtiError
            When a system of python-control is not linear, or improper.
        """
        from stickslip.blocks import component  # late: the process of an FMU needs no blocks

        super().add(name, component(fmu), parameters, interface=interface)

    @named(RunOptions)
    def simulate(
        self,
        *,
        parameters: Mapping[str, Any] | None = None,
        inputs: Inputs | None = None,
        **options: Unpack[RunOptions],
    ) -> Result:
        """Run the system once and return what it recorded; see ``ss.simulate``."""
        from stickslip.simulation import simulate  # late: the process of an FMU does not need it

        return simulate(self, parameters=parameters, inputs=inputs, **options)

    @named(SweepOptions)
    def sweep(
        self,
        parameters: Mapping[str, Iterable[float | str]],
        figures: Mapping[str, Figure],
        **options: Unpack[SweepOptions],
    ) -> pd.DataFrame:
        """Run the system for every combination of parameter values; see ``ss.sweep``."""
        from stickslip.sweeping import sweep  # late, for those who start quickly

        return sweep(self, parameters, figures, **options)

    @named(SearchOptions)
    def optimise(
        self, ranges: Mapping[str, Sequence[float]], cost: Figure, **options: Unpack[SearchOptions]
    ) -> Optimum:
        """Search the parameters for which a cost is least; see ``ss.optimise``."""
        from stickslip.sweeping import optimise  # late, for those who start quickly

        return optimise(self, ranges, cost, **options)


def read_ssp(
    path: str | os.PathLike[str], variant: str | None = None
) -> tuple[System, DefaultExperiment]:
    """Read a system and the times it proposes.

    Components of nested systems are called ``outer/inner``, so that their variables are
    ``outer/inner.variable``. The system remembers the package: written again, it keeps all that is
    not read of it.

    Parameters
    ----------
    path : the ``.ssp`` file
    variant : name of one of the systems that the file describes; the default one if left out

    Raises
    ------
    SspError
        When the file is not an SSP package, or a component is not an FMU.
    """
    from stickslip import cosim  # as above

    read, experiment = cosim.read_ssp(path, variant)
    return System.of(read), experiment


def closed_loop(
    loop: VelocityLoop,
    compensators: Sequence[Compensator] = (),
    *,
    folder: Path | str = "fmus",
    law: str = "lugre",
    drive: Mapping[str, object] | None = None,
) -> System:
    """Build the FMUs of a velocity loop around a simulated drive, and connect them.

    The components are ``nominal``, the loop without friction, whose output ``v_r`` is the velocity
    to be reached; ``controller``, ``drive``, and the compensators by their names. The input
    ``v_cmd`` is the velocity command [m/s]; run it with ``step=loop.T_s``.

    Parameters
    ----------
    loop : controller gains and axis
    compensators : in the order in which their forces are added
    folder : for the FMUs
    law : friction law of the drive
    drive : start values of the drive by variable, such as ``F_c``; mass, viscous friction and lag
        of the motor are those of the loop's axis unless given here

    Raises
    ------
    UnknownLaw, UnknownModel
        When there is no such law or compensator.
    ParameterError
        When the drive has no such variable, or not for this value.
    ValueError
        When a model is no compensator, or cannot take the force of the one before it.
    """
    from stickslip import models  # late, as above
    from stickslip.servo.chain_response import built
    from stickslip.servo.systems import build_loop

    fmus = Path(folder) / law
    models.build_fmu("drive", fmus, law=law)
    chain = built(fmus, ("nominal_loop", "velocity_controller"), compensators)
    system = System.of(build_loop(fmus, loop, chain))
    for name, value in {**loop.axis.of_drive(), **(drive or {})}.items():
        system.set(f"drive.{name}", value)
    return system
