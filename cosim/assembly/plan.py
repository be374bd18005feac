"""What follows from the settings of a simulation alone: order, layout and points in time."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property

import numpy as np

from stickslip.cosim.assembly.layout import Layout
from stickslip.cosim.errors import ExperimentError, ParameterError
from stickslip.cosim.fmu.values import converted
from stickslip.cosim.signals.signals import Array
from stickslip.cosim.signals.span import slack
from stickslip.cosim.system.coupling import Coupling
from stickslip.cosim.system.experiment import check_memory, check_tolerance, count_steps
from stickslip.cosim.system.loops import group
from stickslip.cosim.system.record import Record
from stickslip.cosim.system.system import Specification
from stickslip.fmi.description.variables import Value, Variable


class Plan:
    """A specification that was checked, and what it means.

    Attributes
    ----------
    spec : Specification
    n_steps : from start to stop
    coupling : Coupling
    groups : components that are iterated together, in the order in which they step
    order : names of the components as they step
    record : Record
    layout : of a row of the kernel
    """

    def __init__(self, spec: Specification) -> None:
        self.spec, system = spec, spec.system
        self.n_steps = count_steps(spec.start, spec.stop, spec.step)
        check_tolerance(spec.tolerance)
        self.coupling = Coupling.of(spec.coupling)
        self.groups = group(system, self.coupling)
        self.order = [name for members in self.groups for name in members.components]
        self.record = Record.of(spec.record)
        turn = None if self.coupling.method == "jacobi" else self.order
        self.layout = Layout.of(system, self.record, turn)
        self._kept = self.layout.kept_per_point(self.record)
        self._variables: dict[str, Variable] = {}  # those that runs have set
        check_memory(self.n_steps + 1, self._kept)

    @cached_property
    def time(self) -> Array:
        """The points in time, (n_steps + 1,) s; raises ExperimentError without room for a run."""
        self.check_memory()
        return self.spec.start + self.spec.step * np.arange(self.n_steps + 1, dtype=np.float64)

    @property
    def near(self) -> float:
        """How far two times may lie apart that are meant to be the same, s."""
        return float(slack(max(abs(self.spec.start), abs(self.spec.stop)), self.spec.step))

    @property
    def rows(self) -> int:
        """How many rows a result may have; an FMU that ends a run adds one."""
        return 1 if self.record.keep == "last" else self.n_steps // self.record.every + 2

    def check_memory(self, per_point: float = 0) -> None:
        """Check that there is room for a run, with so many numbers more at each point in time.

        Raises
        ------
        ExperimentError
            When there is not.
        """
        per_point += 1 + len(self.spec.system.inputs) + self._kept
        check_memory(self.n_steps + 1, per_point)

    def step_at(self, until: float | None) -> int:
        """Return the number of the step that ends at a time (s), by default of the last.

        Raises
        ------
        ExperimentError
            When none does.
        """
        if until is None:
            return self.n_steps
        steps = (until - self.spec.start) / self.spec.step
        n = round(steps) if math.isfinite(steps) else 0
        t = self.spec.start + n * self.spec.step
        if not 0 < n <= self.n_steps or abs(t - until) > slack(until, self.spec.step):
            raise ExperimentError(f"until = {until} s is not a point in time of the run")
        return n

    def start_values(self, parameters: Mapping[str, object]) -> dict[str, Value]:
        """Return the start values of a run, with those that it sets itself.

        Raises
        ------
        ParameterError
            When there is no such variable, or it cannot have that value.
        """
        system = self.spec.system
        values = dict(system.parameters)
        for name, value in parameters.items():
            if name not in self._variables:
                self._variables[name] = system.variable(name, ParameterError)
            variable = self._variables[name]
            values[name] = converted(variable, value, name)
            present = system.parameters.get(name, variable.start)
            if variable.causality == "structuralParameter" and values[name] != present:
                raise ParameterError(
                    f"{name} = {values[name]!r} would change the dimensions of arrays; set it in"
                    " the system, before the simulation is prepared"
                )
        return values
