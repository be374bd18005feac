"""A system: its components, their connections and start values; and the settings of a run."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from stickslip.cosim.component import (
    Component,
    Interface,
    check_name,
    component_of,
    converted,
    resized,
    variable_of,
)
from stickslip.cosim.display import html_table
from stickslip.cosim.errors import ConnectionFault, CosimError, ParameterError
from stickslip.cosim.fmu.fmu import Fmu
from stickslip.cosim.system.drawing import block_diagram
from stickslip.cosim.system.scaling import (
    PLAIN,
    End,
    Link,
    Scaling,
    check_connection,
    pairs,
    transform,
)
from stickslip.cosim.system.settings import Coupling, Isolated, Isolation, Method, Record
from stickslip.fmi import toolchain
from stickslip.fmi.by_name import by_name
from stickslip.fmi.description.units import Unit
from stickslip.fmi.description.variables import Value, Variable
from stickslip.fmi.messages import shown, suggestion

if TYPE_CHECKING:
    from stickslip.cosim.run.simulation import Simulation


_SHOWN = 12  # start values of a component that a notebook shows


@dataclass(frozen=True)
class Origin:
    """The SSP package of a system, its folder named by its content, and the variant's file."""

    path: Path
    folder: Path
    structure: str = "SystemStructure.ssd"


class System:
    """Components coupled from outputs to inputs. Variables are named ``component.variable``.

    Pickles; FMUs go as their paths.

    Attributes
    ----------
    components : name -> Component, an Fmu or a Function, in the order added
    connections : "component.input" -> "component.output"
    links : "component.input" -> how its source is scaled, where that is not the default
    inputs : name of an exposed input -> the component inputs it is connected to
    input_units : exposed input -> its unit, where that is not the one of its first target
    outputs : name of an exposed output -> the component output it shows
    parameters : "component.variable" -> start value, in the variable's unit
    origin : the SSP package that the system was read from, None when it was not
    """

    def __init__(self, name: str = "system") -> None:
        self.name = name
        self.components: dict[str, Component] = {}
        self.connections: dict[str, str] = {}
        self.links: dict[str, Link] = {}
        self.inputs: dict[str, tuple[str, ...]] = {}
        self.input_units: dict[str, Unit] = {}
        self.outputs: dict[str, str] = {}
        self.parameters: dict[str, Value] = {}
        self.origin: Origin | None = None

    def __repr__(self) -> str:
        return f"System({self.name}: {', '.join(self.components) or 'empty'})"

    def diagram(self) -> str:
        """Return the system as a block diagram, an SVG element in the colour of the text around."""

        def port(name: str) -> tuple[str, str]:
            return component_of(name), variable_of(name)

        wires = [(("", name), port(to)) for name, targets in self.inputs.items() for to in targets]
        wires += [(port(source), port(to)) for to, source in self.connections.items()]
        wires += [(port(source), ("", name)) for name, source in self.outputs.items()]
        return block_diagram({name: part.label for name, part in self.components.items()}, wires)

    def _repr_html_(self) -> str:
        values = dict.fromkeys(self.components, "")
        for name in self.components:
            own = [key for key in self.parameters if component_of(key) == name]
            some = [f"{variable_of(key)} = {self.parameters[key]!r}" for key in own[:_SHOWN]]
            more = [f"{len(own) - _SHOWN} more"] if len(own) > _SHOWN else []
            values[name] = ", ".join(some + more)
        parts = [(name, part.label, values[name]) for name, part in self.components.items()]
        exposed = [(name, target) for name, targets in self.inputs.items() for target in targets]
        pairs = [*exposed, *((source, target) for target, source in self.connections.items())]
        pairs += [(source, f"output {name}") for name, source in self.outputs.items()]
        wires = [(source, target, self.unit(source) or "") for source, target in pairs]
        return (
            self.diagram()
            + html_table(("component", "", "set"), parts, self.name, words=3)
            + html_table(("from", "to", "unit"), wires, words=3)
        )

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
        fmu : an FMU or its path, or a Function
        interface : by which an FMU is run: ``co_simulation``, the default where it has one, or
            ``model_exchange``

        Raises
        ------
        FmuError, ConnectionFault, ParameterError
        """
        if fault := check_name(name):
            raise ConnectionFault(f"{shown(name)} cannot name a component: {fault}")
        if name in self.components:
            what = f"already has a component {name!r}"
            raise ConnectionFault(f"{self.name} {what}; choose another name")
        self.components[name] = _component(name, fmu, interface)
        try:
            for variable, value in by_name("parameters", parameters, ParameterError).items():
                self.set(f"{name}.{variable}", value)
        except ParameterError:
            del self.components[name]
            raise

    def connect(self, source: str, target: str, link: Link = PLAIN) -> None:
        """Connect an output to an input; the value is converted to the unit of the input.

        ``link`` is a scaling beyond that of the units, or none of the units.

        Raises
        ------
        ConnectionFault : an end does not exist, has the wrong causality or type, measures another
            quantity than the other end, or the input already has a source
        """
        purpose = f"cannot connect {source} to {target}"
        for one, other in pairs(self._end(source, purpose), self._end(target, purpose)):
            start = self._end(one, purpose)
            start.check("output", f"cannot connect {one} to {other}")
            self._check_source(start, other, link)
            self._set_link(other, link)
            self.connections[other] = one

    def expose(
        self,
        name: str,
        *targets: str,
        unit: Unit | None = None,
        links: Mapping[str, Link] | None = None,
    ) -> None:
        """Make an input of the system and connect it to inputs of components, in their units.

        Its unit is that of the first target by default. ``links`` give targets a scaling beyond
        that of the units, or none of the units.

        Raises
        ------
        ConnectionFault : the name is taken, or a target does not exist, is not an input, already
            has a source, or measures another quantity than the input
        """
        if fault := check_name(name):
            raise ConnectionFault(f"cannot expose {shown(name)}: {fault}")
        if name in self.inputs or not targets:
            what = "it needs a name that is not taken, and at least one target"
            raise ConnectionFault(f"cannot expose {shown(name)}: {what}")
        if len(set(targets)) < len(targets):
            raise ConnectionFault(f"cannot expose {name!r}: a target occurs twice")
        purpose = f"cannot connect {name} to {targets[0]}"
        first = self._end(targets[0], purpose)
        first.check("input", purpose)
        unit = unit and unit.like(first.unit)
        source = End(name, first.variable, unit or first.unit)
        for target in targets:
            link = (links or {}).get(target, PLAIN)
            self._check_source(source, target, link)
            self._set_link(target, link)
        self.inputs[name] = targets
        if unit:
            self.input_units[name] = unit

    def expose_output(self, name: str, source: str) -> None:
        """Make an output of the system, for tools that take the system as a whole.

        Raises
        ------
        ConnectionFault : the name is taken, or ``source`` is not an output of a component
        """
        if fault := check_name(name):
            raise ConnectionFault(f"cannot expose {shown(name)}: {fault}")
        if name in self.inputs or name in self.outputs:
            raise ConnectionFault(f"cannot expose {shown(name)}: it needs a name that is not taken")
        purpose = f"cannot expose {source} as {name}"
        self._end(source, purpose).check("output", purpose)
        self.outputs[name] = source

    def set(self, name: str, value: object) -> None:
        """Give a variable a start value, in its unit.

        Raises
        ------
        ParameterError : there is no such variable, it cannot be set, or not to this value
        """
        checked = self.checked(name, value)
        component, variable = component_of(name), variable_of(name)
        if isinstance(checked, int) and variable in self.components[component].structural:
            lengths = {**self.lengths(component), variable: checked}
            for array in self.components[component].variables.values():
                resized(array, lengths)
        self.parameters[name] = checked

    def checked(self, name: str, value: object) -> Value:
        """Return ``value`` as ``set`` would store it, or raise ParameterError."""
        return converted(self.variable(name, ParameterError), value, name)

    def variable(self, name: str, error: type[CosimError] = ConnectionFault) -> Variable:
        """Return the variable ``component.variable``; the error suggests names that look alike."""
        component, variable = component_of(name), variable_of(name)
        if component not in self.components:
            near = suggestion(component, self.components)
            owners = [key for key, one in self.components.items() if name in one.variables]
            if owners:
                several = ", ".join(f"{one}.{name}" for one in owners)
                raise error(f"{name!r} is one of several: {several}")
            raise error(f"{self.name} has no component {component!r} (wanted {name!r}){near}")
        fmu = self.components[component]
        found = fmu.find(variable, self.lengths(component))
        if found is None:
            near = suggestion(variable, fmu.variables)
            what = f"component {component!r} ({fmu.label}) has no variable {variable!r}{near}"
            raise error(f"{self.name}: {what}")
        return found

    def lengths(self, component: str) -> dict[str, int]:
        """Return the structural parameters of a component that were set, by variable."""
        names = ((n, f"{component}.{n}") for n in self.components[component].structural)
        values = ((name, self.parameters.get(key)) for name, key in names)
        return {name: value for name, value in values if isinstance(value, int)}

    def unit(self, name: str) -> str | None:
        """Return the unit of an exposed input or of ``component.variable``."""
        unit = self.unit_of(name)
        return unit.name if unit else None

    def unit_of(self, name: str) -> Unit | None:
        """Return what an exposed input or ``component.variable`` is measured in."""
        if name in self.inputs:
            return self.input_units.get(name) or self.unit_of(self.inputs[name][0])
        return self._component(name).unit(self.variable(name))

    def scaling(self, source: str, target: str) -> Scaling:
        """Return the scaling of a number from the source of an input to this input."""
        like = self.inputs[source][0] if source in self.inputs else source
        start = End(source, self.variable(like), self.unit_of(source))
        end = End(target, self.variable(target), self.unit_of(target))
        return transform(start, end, self.links.get(target, PLAIN))

    def sources(self) -> dict[str, str]:
        """Return the source of each connected input: a component's output or an exposed input."""
        exposed = {target: name for name, targets in self.inputs.items() for target in targets}
        return self.connections | exposed

    def fmus(self, purpose: str) -> dict[str, Fmu]:
        """Return the components for a purpose that only FMUs serve, else raise ConnectionFault."""
        for name, component in self.components.items():
            if not isinstance(component, Fmu):
                what = f"but {name} is the Python {component.label}; replace it by an FMU"
                raise ConnectionFault(f"{self.name}: {purpose} needs FMUs, {what}")
        return {n: c for n, c in self.components.items() if isinstance(c, Fmu)}

    def feedthrough(self) -> list[tuple[str, str]]:
        """Return the connections (source, target) whose source has direct feedthrough."""
        return [
            (source, target)
            for target, source in self.connections.items()
            if self._component(source).feedthrough[self.variable(source).owner]
        ]

    def prepare(
        self,
        *,
        step: float,
        stop: float,
        start: float = 0.0,
        record: Record | str | Sequence[str] | None = None,
        coupling: Coupling | Method = "gauss_seidel",
        constant_step: bool = False,
        compiled: bool = False,
        tolerance: float | None = None,
        allow_nan: bool = False,
        isolation: Isolated = "foreign",
    ) -> Simulation:
        """Instantiate the FMUs for any number of runs.

        Parameters
        ----------
        step, stop, start : communication step and interval, s
        record : a Record of what to keep, or its names; every output and exposed input by default
        coupling : a Coupling, or the name of its method
        constant_step : whether the FMUs are given exactly ``step`` as their step size. By
            default they are given the distance of the two points in time (as FMPy does), so that
            point and step size add up exactly
        compiled : whether to compile the steps of this system into C of their own: about a second
            once, then up to a sixth less for cheap FMUs. The values are the same
        tolerance : relative, of the solver of Model Exchange and of those within FMUs.
            By default each FMU has the one that it proposes; where it proposes none, Model Exchange
            takes 1e-5 (as FMPy does) and Co-Simulation is given none. Model Exchange that is
            coupled takes less: a tenth of it divided by the number of steps, at least 1e-10, and
            with adaptive steps 1e-5 of their tolerance
        allow_nan : whether outputs may be NaN or infinite. By default such a value ends the run
        isolation : which systems live in a process of their own, which they may crash, see
            ``Isolated``; an Isolation says how long and how much memory they may take

        Raises
        ------
        ExperimentError, ConnectionFault, FmuError
        """
        kept = record if record is None or isinstance(record, Record) else Record(record).wanted
        settings = (coupling, constant_step, compiled, tolerance, allow_nan, isolation)
        return Specification(self.copy(), step, stop, start, kept, *settings).prepare()

    def copy(self) -> Self:
        """Return a system that can be changed without changing this one; FMUs are shared."""
        twin = type(self)(self.name)
        for name, value in vars(self).items():
            setattr(twin, name, value.copy() if isinstance(value, dict) else value)
        return twin

    def _end(self, name: str, purpose: str) -> End:
        try:
            return End(name, self.variable(name), self.unit_of(name))
        except ConnectionFault as fault:
            raise ConnectionFault(f"{purpose}: {fault}") from None

    def _check_source(self, source: End, name: str, link: Link) -> None:
        purpose = f"cannot connect {source.name} to {name}"
        check_connection(source, self._end(name, purpose), link)
        if present := self.sources().get(name):
            raise ConnectionFault(f"{purpose}: {name} is already connected to {present}")

    def _component(self, name: str) -> Component:
        return self.components[component_of(name)]

    def _set_link(self, target: str, link: Link) -> None:
        if link != PLAIN:
            self.links[target] = link


def _component(name: str, thing: Any, interface: Interface | None) -> Component:
    if isinstance(thing, Fmu) and interface not in (None, thing.interface):
        thing = thing.path
    if isinstance(thing, str | os.PathLike):
        return Fmu(thing, interface=interface)
    if isinstance(thing, Component):
        return thing
    advice = "expected an FMU, its path or a Function"
    raise ConnectionFault(f"{name}: a {type(thing).__name__} is no component; {advice}")


@dataclass(frozen=True)
class Specification:
    """All settings of a simulation, the arguments of ``System.prepare``.

    It pickles, so that each worker can prepare its own.
    """

    system: System
    step: float
    stop: float
    start: float = 0.0
    record: Record | tuple[str, ...] | None = None
    coupling: Coupling | Method = "gauss_seidel"
    constant_step: bool = False
    compiled: bool = False
    tolerance: float | None = None
    allow_nan: bool = False
    isolation: Isolated = "foreign"

    @property
    def limits(self) -> Isolation | None:
        """The limits of the process that the FMUs have for themselves; None without one."""
        limits = Isolation.of(self.isolation)
        components = self.system.components.values()
        if self.isolation == "foreign" and (
            sys.platform != "linux"
            or not all(isinstance(component, Fmu) for component in components)
            or all(map(toolchain.compiled_here, {component.binary for component in components}))
        ):
            return None
        return limits

    def prepare(self) -> Simulation:
        """Instantiate the FMUs, here or in a process of their own."""
        limits = self.limits
        if limits is None:
            from stickslip.cosim.run.simulation import Simulation

            return Simulation(self)
        from stickslip.cosim.isolation.simulation import IsolatedSimulation

        self.system.fmus("isolation")
        return IsolatedSimulation(self, limits)
