"""An FMU: a file of FMI 2.0 or 3.0, checked, unpacked and described."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import fmpy
from lxml import etree

import toolchain
from cosim.archive import unpack
from cosim.errors import FmuError
from cosim.experiment import DefaultExperiment
from cosim.units import Unit
from cosim.variables import Variable

_C_IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


class Fmu:
    """A Co-Simulation FMU that this machine can run.

    Pickles as its path.

    Attributes
    ----------
    path : the ``.fmu`` file
    folder : where it lies unpacked, under a hash of its content
    version : 2 or 3
    name : of the model
    token : the GUID of FMI 2.0, the instantiation token of FMI 3.0
    variables : name -> Variable, in the order of the description
    units : name -> Unit
    feedthrough : output -> the inputs it depends on without delay
    experiment : the times it proposes, s
    serializes : whether its state can be put into a file

    Raises
    ------
    FmuError
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path).absolute()
        self.folder = unpack(self.path, "fmus", FmuError)
        self.version = self._read_version()
        description = self._read_description()
        self.name: str = description.modelName or self.path.stem
        self.token: str = description.instantiationToken or description.guid or ""
        if description.coSimulation is None:
            raise FmuError(
                f"{self.path}: no Co-Simulation interface; export the model for Co-Simulation"
            )
        self.identifier: str = description.coSimulation.modelIdentifier or ""
        self.binary = self._find_binary()
        self.serializes = bool(description.coSimulation.canSerializeFMUstate)
        self.units: Mapping[str, Unit] = {
            unit.name: Unit.from_fmpy(unit) for unit in description.unitDefinitions
        }
        try:
            variables = [Variable.from_fmpy(variable) for variable in description.modelVariables]
        except (KeyError, ValueError) as fault:
            raise FmuError(
                f"{self.path}: modelDescription.xml holds a bad value: {fault}"
            ) from fault
        self.variables: Mapping[str, Variable] = MappingProxyType({v.name: v for v in variables})
        self.feedthrough = self._read_feedthrough(description)
        times = description.defaultExperiment
        self.experiment = DefaultExperiment(
            _number(getattr(times, "startTime", None)),
            _number(getattr(times, "stopTime", None)),
            _number(getattr(times, "stepSize", None)),
        )

    def __reduce__(self) -> tuple[type[Fmu], tuple[Path]]:
        return Fmu, (self.path,)

    def __repr__(self) -> str:
        return f"Fmu({str(self.path)!r})"

    def unit(self, variable: Variable) -> Unit | None:
        """Return the unit of one of this FMU's variables, None when it has none."""
        if variable.unit is None:
            return None
        return self.units.get(variable.unit, Unit(variable.unit))

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
        if version is None or not re.fullmatch(r"2\.0|3\.\d+", version):
            raise FmuError(
                f"{self.path}: fmiVersion is {version!r}, expected '2.0' or '3.0';"
                " export the model again for one of these"
            )
        return int(version[0])

    def _read_description(self) -> Any:
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
        if not binary.is_file():
            present = sorted(p.name for p in binaries.iterdir()) if binaries.is_dir() else []
            raise FmuError(
                f"{self.path}: no binary for this machine: expected"
                f" binaries/{place}/{binary.name}, the FMU has {', '.join(present) or 'none'}"
            )
        return binary

    def _read_feedthrough(self, description: Any) -> Mapping[str, frozenset[str]]:
        inputs = frozenset(v.name for v in self.variables.values() if v.causality == "input")
        outputs = (v.name for v in self.variables.values() if v.causality == "output")
        feedthrough = dict.fromkeys(outputs, inputs)
        for unknown in description.outputs:
            if unknown.dependencies is not None:
                names = frozenset(variable.name for variable in unknown.dependencies)
                feedthrough[unknown.variable.name] = inputs & names
        return feedthrough


def _number(text: str | None) -> float | None:
    return None if text is None else float(text)
