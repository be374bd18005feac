"""The state of a whole system in the middle of a run: taken, as a file, and put back."""

from __future__ import annotations

import io
import json
import os
import re
import struct
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.cosim.assembly.plan import Plan
from stickslip.cosim.errors import SimulationError
from stickslip.cosim.run.stepping import Stepper, last_outputs
from stickslip.cosim.signals.signals import Array
from stickslip.fmi.files import atomic_write, read_limited
from stickslip.fmi.messages import printable

MOST_BYTES = 1 << 30
FORMAT = 4
_MOST_NAMED = 3  # differences in a message
_MOST_SHOWN = 80  # characters of each
_DAMAGES = (
    *(ValueError, KeyError, TypeError, EOFError, OverflowError, NotImplementedError),
    *(AttributeError, RuntimeError, struct.error, zipfile.BadZipFile, zlib.error),
)
"""What zipfile and numpy make of bytes that are no saved state."""
_HEADER = re.compile(
    rb"\x93NUMPY\x01\x00..\{'descr': '([<|](?:[fiu][1248]|b1|U\d{1,7}))', 'fortran_order': False,"
    rb" 'shape': \((\d{1,12})?,?\), *\} *\n",
    re.DOTALL,
)
"""Of the arrays that are saved; numpy's own reader takes a header for Python."""


@dataclass(frozen=True)
class Checkpoint:
    """What is needed to go on with a run in another process.

    Attributes
    ----------
    identity : what must be the same for the run to go on (FMUs, connections, start values, times,
        coupling, signals): what it is -> as text
    step : number of steps done
    row : all signals at that time
    states : component -> state of its FMU
    starts : start values that are numbers
    memory : ``component/name`` of the general path, ``/name`` of the coupling
    """

    identity: Mapping[str, str]
    step: int
    row: Array
    states: Mapping[str, bytes]
    starts: Mapping[str, float]
    memory: Mapping[str, Array]

    def write(self, path: str | os.PathLike[str]) -> Path:
        """Write a file."""
        stream = io.BytesIO()
        arrays: dict[str, Any] = {
            f"state:{name}": np.frombuffer(state, np.uint8) for name, state in self.states.items()
        }
        arrays |= {f"start:{name}": np.array(value) for name, value in self.starts.items()}
        arrays |= {f"memory:{name}": values for name, values in self.memory.items()}
        arrays |= {"format": FORMAT, "identity": json.dumps(self.identity), "step": self.step}
        np.savez(stream, row=self.row, **arrays)
        return atomic_write(Path(path), stream.getvalue())

    def memory_of(self, owner: str) -> dict[str, Array]:
        """Return the memory of a component on the general path; for an empty name the coupling."""
        parts = ((name.rpartition("/"), values) for name, values in self.memory.items())
        return {name: values for (component, _, name), values in parts if component == owner}

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Checkpoint:
        """Read a file."""
        try:
            stream = io.BytesIO(read_limited(path, MOST_BYTES))
            with zipfile.ZipFile(stream) as archive:
                size = sum(member.file_size for member in archive.infolist())
                if size > MOST_BYTES:
                    raise ValueError(f"{size} bytes when unpacked, at most {MOST_BYTES} are")
                arrays = {member: _array(archive.read(member)) for member in archive.namelist()}
            return cls._of({key.removesuffix(".npy"): array for key, array in arrays.items()})
        except OSError as fault:
            raise SimulationError(f"{path}: cannot be read: {fault.strerror or fault}") from fault
        except _DAMAGES as fault:
            text = printable(" ".join(str(fault).split()))
            raise SimulationError(f"{path}: no saved state that can be read: {text}") from fault

    @classmethod
    def _of(cls, arrays: Mapping[str, NDArray[Any]]) -> Checkpoint:
        """Return what arrays by name say; raises ValueError or KeyError when they say nothing."""
        kinds: dict[str, dict[str, NDArray[Any]]] = {"state": {}, "start": {}, "memory": {}}
        for key, values in arrays.items():
            kind, _, name = key.partition(":")
            kinds.get(kind, {})[name] = values
        version = int(arrays.get("format", np.array(1)))
        if version != FORMAT:
            what = f"this version of cosim reads {FORMAT}; run again from the start and save again"
            raise ValueError(f"it is of format {version}, {what}")
        identity = {str(k): str(v) for k, v in json.loads(str(arrays["identity"])).items()}
        states = {n: np.asarray(s, np.uint8).tobytes() for n, s in kinds["state"].items()}
        starts = {name: float(start) for name, start in kinds["start"].items()}
        row = np.asarray(arrays["row"], np.float64)
        return cls(identity, int(arrays["step"]), row, states, starts, kinds["memory"])


def differences(then: Mapping[str, str], now: Mapping[str, str]) -> str:
    """Return the first differences of two identities for a message; empty where they agree."""
    differing = [what for what in {**now, **then} if then.get(what) != now.get(what)]
    parts = [
        f"{printable(what)} was {_cut(then.get(what), now.get(what))}, is"
        f" {_cut(now.get(what), then.get(what))}"
        for what in differing[:_MOST_NAMED]
    ]
    more = len(differing) - len(parts)
    return "; ".join(parts) + (f"; and {more} more" if more else "")


def _cut(text: str | None, other: str | None) -> str:
    """Return a text; of a long one, the part around its first difference from another."""
    if text is None:
        return "absent"
    if len(text) <= _MOST_SHOWN:
        return printable(text)
    pairs = enumerate(zip(text, other or "", strict=False))
    begin = max(0, next((i for i, (a, b) in pairs if a != b), 0) - _MOST_SHOWN // 2)
    return ("..." if begin else "") + printable(text[begin:], _MOST_SHOWN)


def _array(data: bytes) -> NDArray[Any]:
    """Return an array of one dimension or none."""
    head = _HEADER.match(data)
    if head is None:
        raise ValueError("holds what was not saved here")
    shape = () if head[2] is None else (int(head[2]),)
    dtype = np.dtype(head[1].decode())
    return np.frombuffer(data, dtype, offset=head.end()).reshape(shape)


def taken(stepper: Stepper) -> Checkpoint:
    """Return the state of a run that was halted."""
    plan, fmus = stepper.plan, stepper.fmus
    components = plan.spec.system.components
    if mute := [name for name, fmu in components.items() if not fmu.serializes]:
        what = f"{', '.join(mute)} cannot serialise it (canSerializeFMUstate)"
        raise SimulationError(f"the state cannot be saved: {what}")
    row, done = fmus.memory.row(), fmus.run.done
    memory = {f"/{name}": values for name, values in fmus.coupled.memory().items()}
    for owner, general in fmus.general.items():
        memory |= {f"{owner}/{name}": values for name, values in general.memory().items()}
    for name, slot in fmus.slots.items():
        memory[f"{name}/outputs"] = last_outputs(slot)
    states = {name: fmus.state_of(name).save() for name in plan.order}
    starts = {n: float(v) for n, v in stepper.starts.items() if isinstance(v, int | float)}
    return Checkpoint(identity(plan), done, row, states, starts, memory)


def put_back(stepper: Stepper, checkpoint: Checkpoint, path: str | os.PathLike[str]) -> None:
    """Initialise the FMUs of a run that has begun, and bring them into a state read from a file."""
    fmus = stepper.fmus
    stepper.advance(0)  # initialised, the FMUs are in a mode that takes a state
    try:
        for name in stepper.plan.order:
            fmus.state_of(name).restore(checkpoint.states[name])
            general, memory = fmus.general.get(name), checkpoint.memory_of(name)
            if general and "times" in memory and general.recall(memory) not in {0, 1}:
                call = (general.c.called or b"").decode()
                raise SimulationError(f"{name}: {call} failed on resuming")
        fmus.coupled.recall(checkpoint.memory_of(""))
        fmus.memory.go_on(checkpoint.step, checkpoint.row)
    except (KeyError, ValueError, IndexError, TypeError, OverflowError) as fault:
        raise SimulationError(f"{path}: the saved state is damaged: {fault!r}") from fault
    for name, slot in fmus.slots.items():  # the outputs are those that they were
        now = last_outputs(slot)
        then = checkpoint.memory_of(name).get("outputs", now)
        wrong = ~np.isclose(now, then, rtol=1e-6, atol=1e-9, equal_nan=True)
        if wrong.any():
            place = int(np.argmax(wrong))
            fmus.ready = False
            raise SimulationError(
                f"{stepper.plan.layout.outputs[name][place]}: is {now[place]:.9g} after its FMU"
                f" took the state from {path}, but was {then[place]:.9g} when that was saved: the"
                " FMU does not bring back its state, though it declares that it can"
            )


def identity(plan: Plan) -> dict[str, str]:
    """Return what must be the same for a saved state to be a simulation's, by what it is."""
    spec, system = plan.spec, plan.spec.system
    how = {
        "step": float(spec.step),
        "start": float(spec.start),
        "coupling": plan.coupling,
        "constant_step": spec.constant_step,
        "tolerance": spec.tolerance,
        "order of the components": ", ".join(plan.order),
        "signals": ", ".join(plan.layout.columns),
    }
    fmus = {f"component {name}": fmu.identity for name, fmu in system.components.items()}
    wiring = {
        f"input {target}": f"{source}, {system.scaling(source, target)}"
        for target, source in system.sources().items()
    }
    starts = {f"start value of {name}": value for name, value in system.parameters.items()}
    return {what: str(value) for what, value in {**fmus, **wiring, **starts, **how}.items()}
