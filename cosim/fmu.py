"""An FMU: a file of FMI 2.0 or 3.0, checked, unpacked and described."""

from __future__ import annotations

import logging
import os
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, get_args

from lxml import etree

import toolchain
from cosim.archive import unpack
from cosim.clocks import Clock, read_clocks
from cosim.collection import paused_collection
from cosim.errors import FmuError
from cosim.experiment import DefaultExperiment
from cosim.units import Unit
from cosim.variables import Variable, parse_element

Interface = Literal["co_simulation", "model_exchange"]

_log = logging.getLogger(__name__)
_C_IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


class Fmu:
    """An FMU that this machine can run, by one of its interfaces.

    Pickles as its path and interface.

    Parameters
    ----------
    path : the ``.fmu`` file
    interface : ``co_simulation``, the default where the FMU has it, or ``model_exchange``

    Attributes
    ----------
    path : the ``.fmu`` file
    interfaces : all it has that can be run here
    interface : the one it is run by
    folder : where it lies unpacked, under a hash of its content
    version : 2 or 3
    name : of the model
    token : the GUID of FMI 2.0, the instantiation token of FMI 3.0
    variables : name -> Variable, in the order of the description
    units : name -> Unit
    aliases : other name -> name, in FMI 3.0
    feedthrough : output -> the inputs it depends on without delay
    experiment : the times it proposes, s, and the tolerance
    event_mode : whether events between steps are left to us (FMI 3.0 Co-Simulation)
    has_arrays : whether it has more than scalars: arrays, binary values, structural parameters
    structural : names of its structural parameters
    clocks : input clocks that tick by time
    once_per_process : whether there can be one instance only
    serializes : whether its state can be put into a file
    restores_state, interpolates_inputs, varies_step : whether it declares these abilities

    Raises
    ------
    FmuError
    """

    @paused_collection()
    def __init__(self, path: str | os.PathLike[str], *, interface: Interface | None = None) -> None:
        self.path = Path(path).absolute()
        self.folder = unpack(self.path, "fmus", FmuError)
        self.version = self._read_version()
        description = self._read_description()
        self.name: str = description.modelName or self.path.stem
        self.token: str = description.instantiationToken or description.guid or ""
        self.interfaces, self.interface = self._choose(description, interface)
        chosen = (
            description.coSimulation
            if self.interface == "co_simulation"
            else description.modelExchange
        )
        self.identifier: str = chosen.modelIdentifier or ""
        self.event_mode = self.interface == "co_simulation" and _flag(chosen, "hasEventMode")
        self.once_per_process = _flag(chosen, "canBeInstantiatedOnlyOncePerProcess")
        self.serializes = _flag(chosen, "canSerializeFMUstate")
        self.needs_tool = _flag(chosen, "needsExecutionTool")
        self.notes_steps = _flag(chosen, "needsCompletedIntegratorStep")
        self.n_states = int(description.numberOfContinuousStates or 0)
        self.n_indicators = int(description.numberOfEventIndicators or 0)
        self.restores_state = _flag(chosen, "canGetAndSetFMUstate")
        self.interpolates_inputs = _flag(chosen, "canInterpolateInputs")
        self.varies_step = self.interface == "model_exchange" or _flag(
            chosen, "canHandleVariableCommunicationStepSize"
        )
        self.binary = self._find_binary()
        self.units: Mapping[str, Unit] = {
            unit.name: Unit.from_fmpy(unit) for unit in description.unitDefinitions
        }
        try:
            described = [v for v in description.modelVariables if not getattr(v, "alias", None)]
            variables = [Variable.from_fmpy(variable) for variable in described]
        except (KeyError, ValueError) as fault:
            raise FmuError(
                f"{self.path}: modelDescription.xml holds a bad value: {fault}"
            ) from fault
        self.variables: Mapping[str, Variable] = MappingProxyType({v.name: v for v in variables})
        self.aliases = {a.name: v.name for v in described for a in getattr(v, "aliases", ())}
        self.has_arrays = any(
            v.dimensions or v.type == "Binary" or v.causality == "structuralParameter"
            for v in variables
        )
        self.structural = [v.name for v in variables if v.causality == "structuralParameter"]
        self.feedthrough = self._read_feedthrough(description)
        times = description.defaultExperiment
        self.experiment = DefaultExperiment(
            _number(getattr(times, "startTime", None)),
            _number(getattr(times, "stopTime", None)),
            _number(getattr(times, "stepSize", None)),
            _positive(getattr(times, "tolerance", None)),
        )
        if self.needs_tool:
            _log.warning("%s: needs the tool that made it installed on this machine", self.path)
        self.clocks = self._read_clocks()

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuild, (self.path, self.interface)

    def __repr__(self) -> str:
        return f"Fmu({str(self.path)!r})"

    def find(self, name: str, lengths: Mapping[str, int] | None = None) -> Variable | None:
        """Return a variable by its name, by an alias, or an element of an array: ``name[i,j]``.

        Parameters
        ----------
        lengths : structural parameter -> value, where it is not its start value
        """
        variable = self.variables.get(name) or self.variables.get(self.aliases.get(name, ""))
        if variable is not None:
            variable = variable.shaped(lengths) if lengths else variable
            return variable if variable.name == name else replace(variable, name=name)
        if element := parse_element(name):
            array = self.find(element[0], lengths)
            return array.at(element[1]) if array is not None else None
        return None

    def unit(self, variable: Variable) -> Unit | None:
        """Return the unit of one of this FMU's variables, None when it has none."""
        if variable.unit is None:
            return None
        return self.units.get(variable.unit, Unit(variable.unit))

    def _choose(
        self, description: Any, wanted: Interface | None
    ) -> tuple[tuple[Interface, ...], Interface]:
        present = {
            "co_simulation": description.coSimulation,
            "model_exchange": description.modelExchange,
        }
        interfaces = tuple(name for name in get_args(Interface) if present[name] is not None)
        if not interfaces:
            raise FmuError(
                f"{self.path}: no Co-Simulation or Model Exchange interface"
                f"{', only Scheduled Execution' if description.scheduledExecution else ''};"
                " export the model for Co-Simulation"
            )
        if wanted is not None and wanted not in interfaces:
            raise FmuError(f"{self.path}: no interface {wanted!r}; it has {', '.join(interfaces)}")
        return interfaces, wanted or interfaces[0]

    def _read_version(self) -> int:
        file = self.folder / "modelDescription.xml"
        if not file.is_file():
            raise FmuError(f"{self.path}: modelDescription.xml is missing; this is no FMU")
        try:
            with file.open("rb") as stream:
                _, root = next(etree.iterparse(stream, events=("start",)))
        except etree.XMLSyntaxError as fault:
            raise FmuError(f"{self.path}: modelDescription.xml: {fault}") from fault
        version = root.get("fmiVersion")
        if version is None or not re.fullmatch(r"2\.0|3\.\d+(\.\d+)?", version):
            raise FmuError(
                f"{self.path}: fmiVersion is {version!r}, expected '2.0' or '3.0';"
                " export the model again for one of these"
            )
        return int(version[0])

    def _read_description(self) -> Any:
        import fmpy  # late, for those who start quickly

        try:
            return fmpy.read_model_description(self.folder, validate=False)
        except Exception as fault:  # FMPy raises whatever it stumbles over
            raise FmuError(
                f"{self.path}: modelDescription.xml cannot be understood"
                f" ({type(fault).__name__}: {fault}); check it with 'fmpy validate'"
            ) from fault

    def _find_binary(self) -> Path:
        if not _C_IDENTIFIER.fullmatch(self.identifier):
            raise FmuError(
                f"{self.path}: modelIdentifier is {self.identifier!r}, expected a C identifier"
            )
        platform = toolchain.host_platform()
        place = platform.fmi2 if self.version == 2 else platform.tuple
        binaries = self.folder / "binaries"
        binary = binaries / place / (self.identifier + platform.suffix)
        if binary.is_file():
            return binary
        libraries = sorted((binaries / place).glob(f"*{platform.suffix}"))
        if len(libraries) != 1:
            present = sorted(p.name for p in binaries.iterdir()) if binaries.is_dir() else []
            raise FmuError(
                f"{self.path}: no binary for this machine: expected"
                f" binaries/{place}/{binary.name}, the FMU has {', '.join(present) or 'none'}"
            )
        _log.warning(
            "%s: takes %s, the only library of its folder, though its modelIdentifier is %r",
            self.path,
            libraries[0].name,
            self.identifier,
        )
        return libraries[0]

    def _read_clocks(self) -> list[Clock]:
        """Return the clocks that tick by time; warn of those that will not tick."""
        if not any(v.type == "Clock" and v.causality == "input" for v in self.variables.values()):
            return []
        try:
            clocks = read_clocks(self.folder / "modelDescription.xml")
        except ValueError as fault:
            raise FmuError(f"{self.path}: modelDescription.xml: a clock has {fault}") from fault
        ticking = self.event_mode or self.interface == "model_exchange"
        running = [c for c in clocks if ticking and c.asked is not None]
        if mute := [c.name for c in clocks if c not in running]:
            reason = "only clocks with an interval do" if ticking else "the FMU has no event mode"
            _log.warning("%s: the clocks %s never tick: %s", self.path, ", ".join(mute), reason)
        self.restores_state = self.restores_state and not running
        return running

    def _read_feedthrough(self, description: Any) -> Mapping[str, frozenset[str]]:
        inputs = frozenset(v.name for v in self.variables.values() if v.causality == "input")
        outputs = (v.name for v in self.variables.values() if v.causality == "output")
        feedthrough = dict.fromkeys(outputs, inputs)
        for unknown in description.outputs:
            if unknown.dependencies is not None:
                names = frozenset(map(_true_name, unknown.dependencies))
                feedthrough[_true_name(unknown.variable)] = inputs & names
        return feedthrough


def _rebuild(path: Path, interface: Interface) -> Fmu:
    return Fmu(path, interface=interface)


def _true_name(variable: Any) -> str:
    """Return the name of a variable of FMPy, or of the one of which it is an alias."""
    name: str = (getattr(variable, "alias", None) or variable).name
    return name


def _flag(interface: Any, name: str) -> bool:
    value = getattr(interface, name, False)
    return value in {True, "true", "1"}


def _number(text: str | None) -> float | None:
    return None if text is None else float(text)


def _positive(text: str | None) -> float | None:
    number = _number(text)
    return number if number is not None and 0 < number < 1 else None
