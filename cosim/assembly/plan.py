"""What follows from the settings of a simulation alone: layout of a row, order, points in time."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cached_property
from numbers import Real
from typing import TypeVar

import numpy as np

from stickslip.cosim.component import component_of, converted
from stickslip.cosim.errors import ConnectionFault, ExperimentError, ParameterError
from stickslip.cosim.signals.signals import Array, slack
from stickslip.cosim.system.loops import group
from stickslip.cosim.system.settings import Coupling, Record
from stickslip.cosim.system.system import Specification, System
from stickslip.fmi.description.variables import Value, Variable
from stickslip.fmi.messages import suggestion

T = TypeVar("T", float, Array)


@dataclass(frozen=True)
class Layout:
    """Columns of a row: exposed inputs, then per component its linked and its other outputs.

    Components come in the order that costs least; that of the system where rows of steps in turn
    are the record.

    Attributes
    ----------
    columns : name -> column
    outputs : component -> names of its columns, those that other components read first
    linked : component -> how many of its outputs other components read
    recorded : the names to keep: exposed inputs, then by component in the order of the system
    whole : whether the rows are the record, all signals of all points in time
    texts : the variables of type String to keep, which have no column
    """

    columns: dict[str, int]
    outputs: dict[str, list[str]]
    linked: dict[str, int]
    recorded: list[str]
    whole: bool
    texts: list[str]

    def kept_per_point(self, record: Record) -> float:
        """Return how many numbers of a point in time are kept."""
        if record.keep != "all":
            return 0
        return len(self.columns) if self.whole else len(self.recorded) / record.every

    @cached_property
    def places(self) -> list[int] | None:
        """Where the recorded signals are in rows that are the record; None if in order."""
        found = [self.columns[name] for name in self.recorded]
        return found if self.whole and found != sorted(found) else None

    @classmethod
    def of(cls, system: System, record: Record, turn: Iterable[str] | None = None) -> Layout:
        """Lay out a system; ``turn`` is the order of the steps where each sees those before it."""
        kept, texts = _select(system, record.wanted)
        outputs: dict[str, list[str]] = {component: [] for component in system.components}
        for source in dict.fromkeys(system.connections.values()):
            outputs[component_of(source)].append(source)
        linked = {component: len(names) for component, names in outputs.items()}
        read = set(system.connections.values())
        for name in kept:
            if name not in system.inputs and name not in read:
                outputs[component_of(name)].append(name)
        usual = _columns(system, outputs, outputs)
        recorded = sorted(kept, key=usual.__getitem__)
        whole = len(recorded) == len(usual) and record.every == 1 and record.keep == "all"
        order = turn or _neighbours(system)
        columns = usual if whole and turn else _columns(system, outputs, order)
        return cls(columns, outputs, linked, recorded, whole, texts)


def _columns(system: System, outputs: dict[str, list[str]], order: Iterable[str]) -> dict[str, int]:
    names = [*system.inputs, *(name for component in order for name in outputs[component])]
    return {name: column for column, name in enumerate(names)}


def _neighbours(system: System) -> list[str]:
    """Return the components so that sources of one are neighbours, which needs no gathering.

    The sources of a component that steps in its turn are of two rows: those that step before it are
    side by side in the order of the steps, and the last column of a row is beside the first of the
    next.
    """
    sources: dict[str, list[str]] = {component: [] for component in system.components}
    for target, source in system.connections.items():
        sources[component_of(target)].append(component_of(source))
    several = (found for found in sources.values() if len(set(found)) > 1)
    first = [component for found in several for component in found]
    return list(dict.fromkeys([*first, *system.components]))


def _select(system: System, record: Iterable[str] | None) -> tuple[list[str], list[str]]:
    """Return the signals and the variables of type String to keep."""
    shown = _of_causality(system, "output") or [
        name
        for name in _of_causality(system, "local")
        if system.variable(name).variability not in {"constant", "fixed"}
    ]
    usual = [*system.inputs, *shown]
    strings = {
        f"{component}.{v.name}": v.causality
        for component, fmu in system.components.items()
        for v in fmu.variables.values()
        if v.type == "String" and not v.dimensions
    }
    told = [name for name, causality in strings.items() if causality == "output"]
    if record is None:
        return usual, told
    kept: dict[str, None] = {}
    texts: dict[str, None] = {}
    for wanted in record:
        found = [name for name in usual if name == wanted or fnmatchcase(name, wanted)]
        fit = [wanted] if wanted in strings else [n for n in told if fnmatchcase(n, wanted)]
        if not (found or fit) and any(mark in wanted for mark in "*?"):
            what = f"no output fits{suggestion(wanted, usual)}"
            raise ConnectionFault(f"cannot record {wanted!r}: {what}")
        if found or not fit:
            kept |= dict.fromkeys(found or _recordable(system, wanted))
        texts |= dict.fromkeys(fit)
    return list(kept), list(texts)


def _of_causality(system: System, causality: str) -> list[str]:
    return [
        f"{component}.{element.name}"
        for component, fmu in system.components.items()
        for v in fmu.variables.values()
        if v.causality == causality
        for element in system.variable(f"{component}.{v.name}").elements()
        if element.is_signal
    ]


def _recordable(system: System, name: str) -> list[str]:
    try:
        variable = system.variable(name)
    except ConnectionFault as fault:
        raise ConnectionFault(f"cannot record {name}: {fault}") from None
    elements = [element for element in variable.elements() if element.is_signal]
    if not elements:
        what = f"it is {variable.type}, expected a number, Boolean or String"
        raise ConnectionFault(f"cannot record {name}: {what}")
    return [f"{component_of(name)}.{element.name}" for element in elements]


MAX_STEPS = 10**10
_SHARE = 0.8  # of a machine's memory that a run may take
_NUMBER = 8  # bytes
_PART = 2**16  # numbers of a result that are handed on together


class Plan:
    """A specification that was checked, and what it means.

    The kernel steps ``order``, the components of ``groups``, each of which is iterated together.
    """

    def __init__(self, spec: Specification) -> None:
        self.spec, system = spec, spec.system
        self.n_steps = count_steps(spec.start, spec.stop, spec.step)
        if spec.tolerance is not None and not 0 < spec.tolerance < 1:
            what = "expected a number between 0 and 1"
            raise ExperimentError(f"tolerance is {spec.tolerance}, {what}")
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
        check_memory(self.n_steps + 1, 1 + len(self.spec.system.inputs) + self._kept)
        return self.at(np.arange(self.n_steps + 1, dtype=np.float64))

    def at(self, step: T) -> T:
        """Return the time (s) at the end of a step or of several, the same bits as in ``time``."""
        return self.spec.start + self.spec.step * step

    @property
    def near(self) -> float:
        """How far two times may lie apart that are meant to be the same, s."""
        return float(slack(max(abs(self.spec.start), abs(self.spec.stop)), self.spec.step))

    @property
    def rows(self) -> int:
        """How many rows a result may have; an FMU that ends a run adds one."""
        few = {"last": 1, "range": max(3, self.part + 1)}
        return few.get(self.record.keep, self.n_steps // self.record.every + 2)

    @property
    def part(self) -> int:
        """How many points a part of a result has that is handed on as the run goes."""
        points = self.n_steps // self.record.every + 1
        return min(points, -(-_PART // (1 + len(self.layout.recorded))))

    def step_at(self, until: float | None) -> int:
        """Return the number of the step that ends at a time (s), by default of the last."""
        if until is None:
            return self.n_steps
        n = self.step_near(until)
        t = self.spec.start + n * self.spec.step
        if not 0 < n <= self.n_steps or abs(t - until) > slack(until, self.spec.step):
            raise ExperimentError(f"until = {until} s is not a point in time of the run")
        return n

    def step_near(self, time: float) -> int:
        """Return the number of the step that ends next to a time (s)."""
        steps = (time - self.spec.start) / self.spec.step
        return round(steps) if math.isfinite(steps) else 0

    def start_values(self, parameters: Mapping[str, object]) -> dict[str, Value]:
        """Return the start values of a run, with those that it sets itself."""
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
        if isinstance(value, bool) or not isinstance(value, Real):
            raise ExperimentError(f"{name} is {value!r:.80}, expected a number, in s")
    if not (all(map(math.isfinite, (start, stop, step))) and step > 0 and stop > start):
        what = "must be finite, the step must be positive, and stop must lie after start"
        raise ExperimentError(f"start {start} s, stop {stop} s and step {step} s {what}")
    exact = (stop - start) / step
    if exact > MAX_STEPS:
        raise ExperimentError(
            f"a step of {step} s makes {exact:.3g} steps of the interval {start} to {stop} s, at"
            f" most {MAX_STEPS:.0e} are done; choose a larger step or an earlier stop"
        )
    if 4 * math.ulp(max(abs(start), abs(stop))) > step:
        what = f"is lost in rounding at times of {stop:.9g} s; choose a larger one"
        raise ExperimentError(f"a step of {step} s {what}")
    n = round(exact)
    rounding = math.ulp(max(abs(start), abs(stop))) / step
    if n < 1 or abs(exact - n) > 1e-9 * n + rounding:
        raise ExperimentError(
            f"a step of {step} s does not divide the interval {start} to {stop} s:"
            f" it holds {exact:.9g} steps; choose a stop of {start + max(1, n) * step:.9g} s, or a"
            f" step of {(stop - start) / max(1, n):.12g} s"
        )
    return n


def check_memory(points: int, columns: float) -> None:
    """Check that a machine has room for so many numbers of each point in time."""
    try:
        present = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError):  # not on Windows
        return
    needed = points * columns * _NUMBER
    if needed > _SHARE * present:
        what = f"{points:.3g} points of {columns:.3g} numbers: {needed / 1e9:.3g} GB"
        room = f"where the machine has {present / 1e9:.3g} GB"
        advice = "record less, fewer points or a shorter time"
        raise ExperimentError(f"the run would keep {what}, {room}; {advice}")
