"""A system: FMUs, who feeds whom, and with which start values."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence

from cosim.coupling import Coupling, Method
from cosim.errors import ConnectionFault, CosimError, ParameterError
from cosim.fmu import Fmu
from cosim.names import component_of, suggestion, variable_of
from cosim.simulation import Simulation, Specification
from cosim.units import Unit
from cosim.variables import Value, Variable


class System:
    """Components coupled from outputs to inputs. Variables are named ``component.variable``.

    Pickles; FMUs go as their paths.

    Attributes
    ----------
    components : name -> Fmu, in the order added
    connections : "component.input" -> "component.output"
    inputs : name of an exposed input -> the component inputs it feeds
    parameters : "component.variable" -> start value, in the variable's unit
    """

    def __init__(self, name: str = "system") -> None:
        self.name = name
        self.components: dict[str, Fmu] = {}
        self.connections: dict[str, str] = {}
        self.inputs: dict[str, tuple[str, ...]] = {}
        self.parameters: dict[str, Value] = {}

    def add(
        self,
        name: str,
        fmu: Fmu | str | os.PathLike[str],
        parameters: Mapping[str, Value] | None = None,
    ) -> None:
        """Add a component, with start values by variable name.

        Raises
        ------
        FmuError, ConnectionFault, ParameterError
        """
        if not name or "." in name:
            raise ConnectionFault(f"{name!r} cannot name a component: it is empty or has a dot")
        if name in self.components:
            raise ConnectionFault(
                f"{self.name} already has a component {name!r}; choose another name"
            )
        self.components[name] = fmu if isinstance(fmu, Fmu) else Fmu(fmu)
        try:
            for variable, value in (parameters or {}).items():
                self.set(f"{name}.{variable}", value)
        except ParameterError:
            del self.components[name]
            raise

    def connect(self, source: str, target: str) -> None:
        """Let an output feed an input.

        Raises
        ------
        ConnectionFault
            When an end does not exist, has the wrong causality, type or unit, or is fed already.
        """
        self._check_end(source, "output", f"cannot connect {source} to {target}")
        self._check_feed(source, self.unit_of(source), target)
        self.connections[target] = source

    def expose(self, name: str, *targets: str) -> None:
        """Make an input of the system that feeds inputs of components.

        Raises
        ------
        ConnectionFault
            When the name is taken, or a target does not exist, is no input, is fed already, or
            has another unit than the first.
        """
        if not name or "." in name or name in self.inputs or not targets:
            raise ConnectionFault(
                f"cannot expose {name!r}: it needs a name that is not taken, without a dot,"
                " and at least one target"
            )
        if len(set(targets)) < len(targets):
            raise ConnectionFault(f"cannot expose {name!r}: a target occurs twice")
        self._check_end(targets[0], "input", f"cannot connect {name} to {targets[0]}")
        for target in targets:
            self._check_feed(name, self.unit_of(targets[0]), target)
        self.inputs[name] = targets

    def set(self, name: str, value: object) -> None:
        """Give a variable a start value, in the variable's unit.

        Raises
        ------
        ParameterError
            When there is no such variable, it cannot be set, or not to this value.
        """
        self.parameters[name] = self.checked(name, value)

    def checked(self, name: str, value: object) -> Value:
        """Return ``value`` as ``set`` would store it.

        Raises
        ------
        ParameterError
        """
        return self.variable(name, ParameterError).checked(value, name)

    def variable(self, name: str, error: type[CosimError] = ConnectionFault) -> Variable:
        """Return the variable called ``component.variable``.

        Raises
        ------
        error
            When there is none; names that look alike are suggested.
        """
        component, variable = component_of(name), variable_of(name)
        if component not in self.components:
            near = suggestion(component, self.components)
            raise error(f"{self.name} has no component {component!r} (wanted {name!r}){near}")
        fmu = self.components[component]
        if variable not in fmu.variables:
            near = suggestion(variable, fmu.variables)
            raise error(
                f"{self.name}: component {component!r} ({fmu.path.name}) has no variable"
                f" {variable!r}{near}"
            )
        return fmu.variables[variable]

    def unit(self, name: str) -> str | None:
        """Return the unit of an exposed input or of ``component.variable``."""
        unit = self.unit_of(self.inputs[name][0] if name in self.inputs else name)
        return unit.name if unit else None

    def unit_of(self, name: str) -> Unit | None:
        """Return what ``component.variable`` is measured in."""
        return self._fmu(name).unit(self.variable(name))

    def sources(self) -> dict[str, str]:
        """Return what feeds each input that is fed: a component's output or an exposed input."""
        exposed = {target: name for name, targets in self.inputs.items() for target in targets}
        return self.connections | exposed

    def feedthrough(self) -> list[tuple[str, str]]:
        """Return the connections (source, target) whose source has direct feedthrough."""
        return [
            (source, target)
            for target, source in self.connections.items()
            if self._fmu(source).feedthrough[variable_of(source)]
        ]

    def prepare(
        self,
        *,
        step: float,
        stop: float,
        start: float = 0.0,
        record: Sequence[str] | None = None,
        coupling: Coupling | Method = "gauss_seidel",
        constant_step: bool = False,
    ) -> Simulation:
        """Instantiate the FMUs for any number of runs.

        Parameters
        ----------
        step, stop, start : communication step and interval, s
        record : names or patterns (``drive.*``) of what to keep; every output and exposed input by
            default. A pattern stands for outputs and exposed inputs, a name for any real variable
        coupling : a Coupling, or the name of its method: ``gauss_seidel`` steps components in the
            order of their direct feedthrough, each seeing what was computed before it; ``jacobi``
            delays every connection by one step; ``iterative`` repeats steps until all agree
        constant_step : whether the FMUs are told ``step``, to the bit, as their step size. By
            default they are told the distance of the two points in time (as FMPy does), so that
            point and step size add up exactly

        Raises
        ------
        ExperimentError, ConnectionFault, FmuError
        """
        names = None if record is None else tuple(record)
        return Simulation(
            Specification(self.copy(), step, stop, start, names, coupling, constant_step)
        )

    def copy(self) -> System:
        """Return a system that can be changed without changing this one; FMUs are shared."""
        twin = System(self.name)
        twin.components = dict(self.components)
        twin.connections = dict(self.connections)
        twin.inputs = dict(self.inputs)
        twin.parameters = dict(self.parameters)
        return twin

    def _fmu(self, name: str) -> Fmu:
        return self.components[component_of(name)]

    def _check_end(self, name: str, causality: str, purpose: str) -> None:
        try:
            variable = self.variable(name)
        except ConnectionFault as fault:
            raise ConnectionFault(f"{purpose}: {fault}") from None
        if variable.causality != causality or not variable.is_signal:
            shape = "array" if variable.dimensions else variable.causality
            raise ConnectionFault(
                f"{purpose}: {name} is a {variable.type} {shape},"
                f" expected a Real or Float64 {causality}"
            )

    def _check_feed(self, source: str, unit: Unit | None, target: str) -> None:
        purpose = f"cannot connect {source} to {target}"
        self._check_end(target, "input", purpose)
        wanted = self.unit_of(target)
        if unit and wanted and not unit.same_as(wanted):
            raise ConnectionFault(
                f"{purpose}: {source} is in {unit.name!r}, {target} in {wanted.name!r};"
                " units are not converted"
            )
        if feeder := self.sources().get(target):
            raise ConnectionFault(f"{purpose}: {target} is fed by {feeder} already")
