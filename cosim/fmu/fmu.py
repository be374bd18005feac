"""An FMU: a file of FMI 1.0, 2.0 or 3.0, checked, unpacked and described."""

from __future__ import annotations

import gc
import hashlib
import logging
import os
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from stickslip.cosim.component import Component, Interface
from stickslip.cosim.display import html_table
from stickslip.cosim.errors import FmuError
from stickslip.fmi import toolchain
from stickslip.fmi.archive import restore, unpack
from stickslip.fmi.archive.directory import is_device
from stickslip.fmi.description import Description, DescriptionFault, read_description
from stickslip.fmi.description.attributes import flag
from stickslip.fmi.description.model import Clock
from stickslip.fmi.messages import shown
from stickslip.fmi.xml import Malformed, parse_xml

if TYPE_CHECKING:
    from stickslip.cosim.fmu.library import Library

_log = logging.getLogger(__name__)
_DESCRIPTION = "modelDescription.xml"
_WARNED: set[tuple[Path, str]] = set()
_TAGS: dict[Interface, str] = {"co_simulation": "CoSimulation", "model_exchange": "ModelExchange"}
_SHOWN = 50  # variables that a notebook shows
_IDENTIFIER = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_-]{0,199}")


def _again(path: Path, interface: Interface, digest: str) -> Fmu:
    """Return the FMU that was pickled; FmuError where its file was written again since then."""
    fmu = Fmu(path, interface=interface)
    if fmu.folder.name != digest:
        raise _written_again(path)
    return fmu


def _written_again(path: Path) -> FmuError:
    return FmuError(
        f"{path}: was written again since it was read; build each FMU under a name or in a folder"
        " of its own, or add it again"
    )


@contextmanager
def _paused_collection() -> Iterator[None]:
    """Pause the search for reference cycles: reading 100,000 variables takes half the time."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


class Fmu(Component):
    """An FMU that this machine can run, by one of its interfaces; a Component.

    Pickles as its path and interface.

    Parameters
    ----------
    path : the ``.fmu`` file
    interface : ``co_simulation``, the default where the FMU has it, or ``model_exchange``

    Attributes
    ----------
    interfaces : all it has that can be run here
    folder : where it lies unpacked, under a hash of its content
    version : 2 or 3; FMI 1.0 is run through the functions of FMI 2.0, see ``fmi1.c``
    description, name : all that was read of it, and the name of the model
    token : the GUID of FMI 2.0, the instantiation token of FMI 3.0
    event_mode : whether events between steps are left to us (FMI 3.0 Co-Simulation)
    has_arrays : whether it has more than scalars: arrays, binary values, structural parameters
    clocks : input clocks that tick by time
    once_per_process : whether there can be one instance only

    Raises
    ------
    FmuError
    """

    @_paused_collection()
    def __init__(self, path: str | os.PathLike[str], *, interface: Interface | None = None) -> None:
        self.path = Path(path).absolute()
        self.label = self.path.name
        self.folder, description = described(self.path)
        self.description = description
        self.version = max(2, description.standard)
        self.name = description.name or self.path.stem
        self.token = description.token
        self.interfaces, self.interface = self._choose(description, interface)
        chosen = description.interfaces[_TAGS[self.interface]]
        self.identifier = chosen.get("modelIdentifier", "")
        self.event_mode = self.interface == "co_simulation" and flag(chosen, "hasEventMode")
        self.once_per_process = flag(chosen, "canBeInstantiatedOnlyOncePerProcess")
        self.needs_tool = flag(chosen, "needsExecutionTool")
        state = "state" if self.version == 2 else "State"
        self.serializes = flag(chosen, f"canSerializeFMU{state}")
        self.restores_state = flag(chosen, f"canGetAndSetFMU{state}")
        unneeded = flag(chosen, "completedIntegratorStepNotNeeded")
        needed = flag(chosen, "needsCompletedIntegratorStep") if self.version == 3 else not unneeded
        self.notes_steps = self.interface == "model_exchange" and needed
        self.n_states, self.n_indicators = description.n_states, description.n_indicators
        self.interpolates_inputs = flag(chosen, "canInterpolateInputs")
        varies_step = flag(chosen, "canHandleVariableCommunicationStepSize")
        self.varies_step = self.interface == "model_exchange" or varies_step
        self.binary = self._find_binary()
        self.learned = description.learned
        self.identity = f"{self.interface} of the file with SHA-256 {self.folder.name[:16]}..."
        self.units = description.units
        self.variables = description.variables
        self.aliases = description.aliases
        every = self.variables.values()
        self.structural = [v.name for v in every if v.causality == "structuralParameter"]
        has_arrays = any(v.dimensions or v.type == "Binary" for v in every)
        self.has_arrays = has_arrays or bool(self.structural)
        self.feedthrough = self._read_feedthrough(description)
        self.experiment = description.experiment
        if self.needs_tool:
            _log.warning("%s: needs the tool that made it installed on this machine", self.path)
        self.clocks = self._ticking()
        if not self._knows_events:
            self.variables = {
                name: replace(v, triggered=False) if v.triggered else v
                for name, v in self.variables.items()
            }
        warn_of(self.path, description)

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (self.path, self.interface, self.folder.name)

    def content(self) -> bytes:
        """Return the bytes of its file; FmuError where it is no longer the file that was read."""
        try:
            data = self.path.read_bytes()
        except OSError as fault:
            raise FmuError(f"{self.path}: {fault.strerror}") from fault
        if hashlib.sha256(data).hexdigest() != self.folder.name:
            raise _written_again(self.path)
        return data

    def __repr__(self) -> str:
        return f"Fmu({str(self.path)!r})"

    def _repr_html_(self) -> str:
        kinds = ("input", "output", "parameter", "structuralParameter")
        own = [v for v in self.variables.values() if v.causality in kinds]
        own.sort(key=lambda v: kinds.index(v.causality))
        rows = [
            (v.name, v.causality, v.unit or "", "" if v.start is None else v.start, v.description)
            for v in own[:_SHOWN]
        ]
        more = f", {len(own) - _SHOWN} more" if len(own) > _SHOWN else ""
        caption = f"{self.label}: {self.name}, FMI {self.description.standard}{more}"
        return html_table(("name", "", "unit", "start", "description"), rows, caption, words=5)

    def table(self) -> Library:
        """Return the functions of its binary, see Component."""
        from stickslip.cosim.fmu.library import Library  # late: for those who only read FMUs

        return Library(self)

    def restore(self) -> None:
        """Unpack the FMU again where a run changed its files; FmuError if it is gone or another."""
        restore(self.folder, self.path, FmuError)

    @property
    def _knows_events(self) -> bool:
        return self.event_mode or self.interface == "model_exchange"

    def _choose(
        self, description: Description, wanted: Interface | None
    ) -> tuple[tuple[Interface, ...], Interface]:
        present = description.interfaces
        interfaces = tuple(name for name in get_args(Interface) if _TAGS[name] in present)
        if not interfaces:
            only = ", only Scheduled Execution" if "ScheduledExecution" in present else ""
            what = f"no Co-Simulation or Model Exchange interface{only}"
            raise FmuError(f"{self.path}: {what}; export the model for Co-Simulation")
        if wanted is not None and wanted not in interfaces:
            raise FmuError(f"{self.path}: no interface {wanted!r}; it has {', '.join(interfaces)}")
        return interfaces, wanted or interfaces[0]

    def _find_binary(self) -> Path:
        if not _IDENTIFIER.fullmatch(self.identifier) or is_device(self.identifier):
            raise FmuError(
                f"{self.path}: modelIdentifier is {shown(self.identifier)}, expected a C identifier"
                " of at most 200 characters that names no device of Windows; export it again"
            )
        if not self.identifier.isidentifier():
            _log.info("%s: modelIdentifier %r is no C identifier", self.path, self.identifier)
        platform = toolchain.host_platform()
        place = platform.fmi2 if self.version == 2 else platform.tuple
        binaries = self.folder / "binaries"
        binary = binaries / place / (self.identifier + platform.suffix)
        if binary.is_file():
            return binary
        libraries = [p for p in (binaries / place).glob(f"*{platform.suffix}") if p.is_file()]
        if len(libraries) != 1:
            present = sorted(p.name for p in binaries.iterdir()) if binaries.is_dir() else []
            what = f"binaries/{place}/{binary.name}, the FMU has {', '.join(present) or 'none'}"
            raise FmuError(f"{self.path}: no binary for this machine: expected {what}")
        _log.warning(
            "%s: takes %s, the only library of its folder, though its modelIdentifier is %r",
            self.path,
            libraries[0].name,
            self.identifier,
        )
        return libraries[0]

    def _ticking(self) -> list[Clock]:
        """Return the clocks that tick by time; warn of those that will not tick."""
        clocks = self.description.clocks
        if clocks and not self._knows_events:
            names = ", ".join(clock.name for clock in clocks)
            line = "%s: the clocks %s never tick: the FMU has no event mode"
            _log.warning(line, self.path, names)
            return []
        return [clock for clock in clocks if clock.asked is not None]

    def _read_feedthrough(self, description: Description) -> Mapping[str, frozenset[str]]:
        inputs = frozenset(v.name for v in self.variables.values() if v.causality == "input")
        outputs = (v.name for v in self.variables.values() if v.causality == "output")
        feedthrough = dict.fromkeys(outputs, inputs)
        for unknown in description.outputs:
            if unknown.dependencies is not None:
                feedthrough[unknown.name] = inputs.intersection(unknown.dependencies)
        return feedthrough


def described(path: Path) -> tuple[Path, Description]:
    """Return folder and description of an FMU, also one that this machine cannot run."""
    folder = unpack(path, "fmus", FmuError)
    names = {file.name for file in folder.iterdir()}
    if _DESCRIPTION not in names:
        near = [
            shown(str(file.relative_to(folder)))
            for file in folder.rglob("*")
            if file.name.casefold() == _DESCRIPTION.casefold()
        ]
        hint = f"; there is {near[0]}, which must be at the root and spelled so" if near else ""
        raise FmuError(f"{path}: {_DESCRIPTION} is missing; this is not an FMU{hint}")
    try:
        return folder, _description(folder)
    except (Malformed, DescriptionFault) as fault:
        raise FmuError(f"{path}: {_DESCRIPTION}: {fault}") from fault


@lru_cache(maxsize=64)
def _description(folder: Path) -> Description:
    """Return what a folder describes, whose name is a hash of its content."""
    return read_description(parse_xml((folder / _DESCRIPTION).read_bytes()))


def warn_of(path: Path, description: Description) -> None:
    """Log what is left out of a description, once."""
    if (path, description.token) not in _WARNED:
        _WARNED.add((path, description.token))
        for line in description.remarks:
            _log.warning("%s: %s: %s", path, _DESCRIPTION, line)
