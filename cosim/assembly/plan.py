"""What follows from the settings of a simulation alone: order, layout and points in time."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from functools import cached_property
from numbers import Real

import numpy as np

from stickslip.cosim.assembly.layout import Layout
from stickslip.cosim.errors import ExperimentError, ParameterError
from stickslip.cosim.fmu.values import converted
from stickslip.cosim.signals.signals import Array
from stickslip.cosim.signals.span import slack
from stickslip.cosim.system.coupling import Coupling
from stickslip.cosim.system.loops import group
from stickslip.cosim.system.record import Record
from stickslip.cosim.system.system import Specification
from stickslip.fmi.description.variables import Value, Variable

MAX_STEPS = 10**10
_SHARE = 0.8  # of a machine's memory that a run may take
_NUMBER = 8  # bytes


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


def count_steps(start: float, stop: float, step: float) -> int:
    """Return how many steps lead from start to stop (all in s)."""
    for name, value in (("start", start), ("stop", stop), ("step", step)):
        if not isinstance(value, Real):
            raise ExperimentError(f"{name} is {value!r:.80}, expected a number, in s")
    if not (all(map(math.isfinite, (start, stop, step))) and step > 0 and stop > start):
        raise ExperimentError(
            f"start {start} s, stop {stop} s and step {step} s must be finite, the step must be"
            " positive, and stop must lie after start"
        )
    exact = (stop - start) / step
    if exact > MAX_STEPS:
        raise ExperimentError(
            f"a step of {step} s makes {exact:.3g} steps of the interval {start} to {stop} s, at"
            f" most {MAX_STEPS:.0e} are done; choose a larger step or an earlier stop"
        )
    if 4 * math.ulp(max(abs(start), abs(stop))) > step:
        raise ExperimentError(
            f"a step of {step} s is lost in rounding at times of {stop:.9g} s; choose a larger one"
        )
    n = round(exact)
    rounding = math.ulp(max(abs(start), abs(stop))) / step
    if n < 1 or abs(exact - n) > 1e-9 * n + rounding:
        raise ExperimentError(
            f"a step of {step} s does not divide the interval {start} to {stop} s:"
            f" it holds {exact:.9g} steps; choose a stop of {start + max(1, n) * step:.9g} s"
        )
    return n


def check_memory(points: int, columns: float) -> None:
    """Check that a machine has room for what a run keeps.

    Parameters
    ----------
    points : in time
    columns : numbers that are kept of each
    """
    try:
        present = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError):  # not on Windows
        return
    needed = points * columns * _NUMBER
    if needed > _SHARE * present:
        raise ExperimentError(
            f"the run would keep {points:.3g} points of {columns:.3g} numbers: {needed / 1e9:.3g}"
            f" GB, where the machine has {present / 1e9:.3g} GB; record less, fewer points or a"
            " shorter time"
        )


def check_tolerance(tolerance: float | None) -> None:
    """Check a relative tolerance of solvers."""
    if tolerance is not None and not 0 < tolerance < 1:
        raise ExperimentError(f"tolerance is {tolerance}, expected a number between 0 and 1")
