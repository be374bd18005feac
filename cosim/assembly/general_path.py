"""FMUs that need more than steps and doubles: the general path of the kernel."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.ctypeslib import as_array
from numpy.typing import NDArray

from stickslip.cosim.errors import FmuError
from stickslip.cosim.fmu.fmu import Fmu
from stickslip.cosim.fmu.instance import Batch, batches
from stickslip.cosim.fmu.library import Library
from stickslip.cosim.kernel import structures
from stickslip.cosim.kernel.structures import doubles
from stickslip.cosim.signals.signals import Table
from stickslip.cosim.system.settings import Adaptive
from stickslip.fmi.description.variables import Value, Variable

# What it keeps of time, and of each clock, that does not follow from anything else.
_TIMES = ("time", "next_event", "passed")
_TICKS = ("interval", "begin", "ticks", "next")

# Of Model Exchange, where neither the FMU nor the caller proposes one; that of FMPy.
TOLERANCE = 1e-5


def needs_general_path(fmu: Fmu, signals: Iterable[Variable]) -> bool:
    """Return whether an FMU with these signals is more than the kernel's loop takes as it is."""
    return (
        fmu.interface == "model_exchange"
        or fmu.event_mode
        or fmu.has_arrays
        or not all(signal.is_plain for signal in signals)
    )


class GeneralComponent:
    """Room for one component on the general path.

    ``outputs`` are in the order of the columns, ``inputs`` in the one in which the kernel sets
    them; ``ahead`` says for each input whether its value at the end of the step is given.
    ``arrays`` are those whose elements are among them.
    """

    def __init__(
        self,
        fmu: Fmu,
        library: Library,
        outputs: Sequence[Variable],
        inputs: Sequence[Variable],
        ahead: Sequence[bool],
        arrays: Mapping[str, Variable],
        tolerance: float | None,
        *,
        retries_steps: bool = False,
    ) -> None:
        self._arrays = arrays
        self._inputs = batches(library, self._owners(inputs), "Set")
        self._outputs = batches(library, self._owners(outputs), "Get")
        self._start_values: tuple[list[Batch], ...] = ()
        self._names = [variable.name for variable in inputs]
        self._tables: Mapping[str, Table] = {}
        self.c = structures.GeneralComponent(
            version=fmu.version,
            model_exchange=fmu.interface == "model_exchange",
            event_mode=fmu.event_mode,
            notes_steps=fmu.notes_steps,
            inputs=_groups(self._inputs),
            outputs=_groups(self._outputs),
            input_ports=_ports(self._inputs, inputs, ahead),
            output_ports=_ports(self._outputs, outputs, [False] * len(outputs)),
            n_inputs=len(inputs),
            courses=(structures.Course * len(inputs))(),
            before=(ctypes.c_double * len(inputs))(),
            after=(ctypes.c_double * len(inputs))(),
            rates=(ctypes.c_double * (2 * len(inputs)))(),
            tolerance=tolerance or fmu.experiment.tolerance or TOLERANCE,
            n_clocks=len(fmu.clocks),
            clocks=(structures.Clock * len(fmu.clocks))(
                *(structures.Clock(c.reference, c.asked, c.interval, c.shift) for c in fmu.clocks)
            ),
            n_states=fmu.n_states,
            n_indicators=fmu.n_indicators,
            retries_steps=retries_steps,
        )
        self.c.call[:] = _addresses(fmu, library)
        if fmu.interface == "model_exchange":
            self.c.cvode = ctypes.addressof(_cvode(fmu))

    def attach_to(self, slot: structures.Component) -> None:
        """Let a component of the kernel, wired as if it were plain, be on the general path."""
        slot.version = 2
        slot.log = ctypes.pointer(self.c.log)
        slot.input_references = (ctypes.c_uint32 * slot.n_inputs)(*range(slot.n_inputs))
        slot.output_references = (ctypes.c_uint32 * slot.n_outputs)(*range(slot.n_outputs))

    def bind(self, slot: structures.Component, library: ctypes.CDLL) -> None:
        """Take the functions of a dressed component from the library that steps it."""
        self._kernel = library
        names = [f"general_{name}" for (name,) in structures.calls("FMI2_CALLS")]
        slot.call[: len(names)] = [_address(getattr(library, name, None)) for name in names]

    def state_calls(self) -> tuple[int, int, int]:
        """Return the addresses of the functions that save, restore and free its state."""
        functions = (getattr(self._kernel, f"general_{v}FMUstate") for v in ("Get", "Set", "Free"))
        save, restore, free = map(_address, functions)
        return save, restore, free

    def follow_polynomials(self, fresh: Sequence[bool], degree: int) -> int:
        """Let inputs follow those of a coupling; return the call that sets derivatives."""
        for i, known in enumerate(fresh):
            self.c.input_ports[i].ahead = known
        self.c.follows = degree > 0
        return _address(self._kernel.general_SetRealInputDerivatives)

    def tighten(self, n_steps: int, adaptive: Adaptive | None) -> None:
        """Keep the solver's error, which adds up over the steps, below that of the coupling."""
        share, finest = (1e-5 * adaptive.tolerance, 1e-12) if adaptive else (0.1 / n_steps, 1e-10)
        usual = self.c.tolerance
        self.c.tolerance = min(usual, max(finest, share if adaptive else share * usual))

    def tune_call(self) -> int:
        """Return the address of the function that changes tunable parameters between two steps."""
        return _address(self._kernel.general_tune)

    def start_with(self, structure: list[Batch], others: list[Batch], late: list[Batch]) -> None:
        """Take start values from here: of structural parameters, most others, and inputs."""
        self._start_values = (structure, others, late)
        self.c.structure, self.c.start_values, self.c.late = map(_groups, self._start_values)

    def follow(self, tables: Mapping[str, Table]) -> None:
        """Let inputs, by name, follow tables in their own unit; Model Exchange knows them whole."""
        self._tables = tables
        for i, name in enumerate(self._names):
            one = tables.get(name)
            given = (len(one.time), doubles(one.time), doubles(one.values), one.held) if one else ()
            self.c.courses[i] = structures.Course(*given)

    def jump(self, tables: Mapping[str, Table], t: float) -> None:
        """Let inputs follow tables that jump, if at all, at the present time (s)."""
        self.follow(tables)
        if any(table.values[0] != table.values[-1] for table in tables.values()):
            self.c.passed, self.c.next_jump = -math.inf, t

    def hold(self, values: Mapping[str, tuple[Variable, Value]]) -> None:
        """Give the unconnected elements of connected arrays their start values."""
        for variable, value in values.values():
            for batch in self._inputs:
                if variable.owner in self._arrays and batch.holds(variable):
                    batch.put(variable, value)

    def memory(self) -> dict[str, NDArray[Any]]:
        """Return what it keeps from one step to the next that the FMU does not, by name."""
        memory = {name: place.copy() for name, place in self._places().items()}
        memory["times"] = np.array([getattr(self.c, name) for name in _TIMES])
        memory["clocks"] = np.array([getattr(c, name) for c in self._clocks() for name in _TICKS])
        return memory

    def recall(self, memory: Mapping[str, NDArray[Any]]) -> int:
        """Go on with a ``memory`` and a new solver once the FMU has its state; return a status."""
        structures.put_back(self._places(), memory)
        for name, value in zip(_TIMES, memory["times"], strict=True):
            setattr(self.c, name, float(value))
        places = ((clock, name) for clock in self._clocks() for name in _TICKS)
        for (clock, name), value in zip(places, memory["clocks"], strict=True):
            setattr(clock, name, int(value) if name == "ticks" else float(value))
        return int(self._kernel.general_go_on(ctypes.byref(self.c)))

    def lose(self) -> None:
        """Let go of an instance that may not be called any more."""
        self.c.instance = self.c.begun = None
        self._kernel.general_FreeInstance(ctypes.byref(self.c))

    def _clocks(self) -> list[Any]:
        return [self.c.clocks[i] for i in range(self.c.n_clocks)]

    def _places(self) -> dict[str, NDArray[Any]]:
        n = int(self.c.n_inputs)
        ends = {"before": self.c.before, "after": self.c.after} if n else {}
        places: dict[str, NDArray[Any]] = {k: as_array(v, (n,)) for k, v in ends.items()}
        for i, batch in enumerate(self._inputs):
            places[f"inputs{i}"] = as_array(batch.values)
        for i, batch in enumerate(self._outputs):
            if batch.clock:
                places[f"ticks{i}"] = as_array(batch.values)
        return places

    def _owners(self, variables: Iterable[Variable]) -> list[Variable]:
        owners = {v.owner: self._arrays.get(v.owner, v) for v in variables}
        return list(owners.values())


def _groups(sources: Sequence[Batch]) -> structures.Groups:
    groups = (batch.group() for batch in sources)
    return structures.Groups(len(sources), (structures.Group * len(sources))(*groups))


def _ports(sources: Sequence[Batch], variables: Sequence[Variable], ahead: Sequence[bool]) -> Any:
    ports = (structures.Port * len(variables))()
    for port, variable, early in zip(ports, variables, ahead, strict=True):
        port.group = next(i for i, batch in enumerate(sources) if batch.holds(variable))
        port.place = sources[port.group].place(variable)
        port.ahead = early
    return ports


def _addresses(fmu: Fmu, library: Library) -> list[int]:
    needs = "M" if fmu.interface == "model_exchange" else "C"
    needs += "E" * fmu.event_mode + "R" * fmu.restores_state
    needs += "K" * bool(fmu.clocks) + "S" * bool(fmu.structural)
    return [
        0
        if name in {"-", library.lacks_reset} or not set(reasons) & set(needs)
        else library.address(name)
        for _, *names, reasons in structures.calls("GENERAL_CALLS")
        for name in [names[fmu.version - 2]]
    ]


def _address(function: Any) -> int:
    return ctypes.cast(function, ctypes.c_void_p).value or 0 if function else 0


@cache
def _cvode_table() -> Any:
    from fmpy.sundials import libraries  # loads the libraries, which not every platform has

    places = [value for name, value in vars(libraries).items() if name.startswith("sundials_")]
    names = [name for _, name, *_ in structures.calls("CVODE_CALLS")]
    found = (next(p for p in places if hasattr(p, name)) for name in names)
    pairs = zip(found, names, strict=True)
    return (ctypes.c_void_p * len(names))(*(_address(getattr(p, name)) for p, name in pairs))


def _cvode(fmu: Fmu) -> Any:
    try:
        return _cvode_table()
    except (ImportError, OSError, AttributeError, StopIteration) as fault:
        what = f"CVode, which FMPy has for x86_64-linux, x86_64-windows and darwin ({fault})"
        advice = "use its Co-Simulation interface"
        raise FmuError(f"{fmu.path}: Model Exchange needs the solver {what}; {advice}") from fault
