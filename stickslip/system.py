"""A system as the application gives it: with components of other kinds, and many runs."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Unpack

from stickslip.cosim.system import system
from stickslip.simulation import RunOptions, simulate, with_run_options

if TYPE_CHECKING:
    import pandas as pd

    from stickslip import output
    from stickslip.cosim import DefaultExperiment, Result
    from stickslip.cosim.component import Interface
    from stickslip.cosim.signals.tables import Inputs
    from stickslip.figures import Figure
    from stickslip.sweeping import Optimum, Progress


class System(system.System):
    """Components coupled from outputs to inputs. Variables are named ``component.variable``.

    Its attributes are those of ``cosim.System``.
    """

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

    @with_run_options
    def simulate(
        self,
        *,
        parameters: Mapping[str, Any] | None = None,
        inputs: Inputs | None = None,
        **options: Unpack[RunOptions],
    ) -> Result:
        """Run the system once and return what it recorded; see ``ss.simulate``."""
        return simulate(self, parameters=parameters, inputs=inputs, **options)

    @with_run_options
    def sweep(
        self,
        parameters: Mapping[str, Iterable[float | str]],
        figures: Mapping[str, Figure],
        *,
        inputs: Inputs | None = None,
        workers: int = 1,
        where: str = "threads",
        progress: Progress | bool = False,
        **options: Unpack[RunOptions],
    ) -> pd.DataFrame:
        """Run the system for every combination of parameter values; see ``ss.sweep``."""
        from stickslip.sweeping import sweep  # late, for those who start quickly

        return sweep(
            self,
            parameters,
            figures,
            inputs=inputs,
            workers=workers,
            where=where,
            progress=progress,
            **options,
        )

    @with_run_options
    def optimise(
        self,
        ranges: Mapping[str, Sequence[float]],
        cost: Figure,
        *,
        inputs: Inputs | None = None,
        evaluations: int = 300,
        algorithm: str = "default",
        seed: int = 0,
        workers: int = 1,
        where: str = "threads",
        progress: output.Progress | Progress | bool = False,
        **options: Unpack[RunOptions],
    ) -> Optimum:
        """Search the parameters for which a cost is least; see ``ss.optimise``."""
        from stickslip.sweeping import optimise  # late, for those who start quickly

        return optimise(
            self,
            ranges,
            cost,
            inputs=inputs,
            evaluations=evaluations,
            algorithm=algorithm,
            seed=seed,
            workers=workers,
            where=where,
            progress=progress,
            **options,
        )


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
    found = System(read.name)
    vars(found).update(vars(read))
    return found, experiment
