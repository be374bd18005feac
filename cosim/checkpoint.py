"""The state of a whole system in the middle of a run, as a file."""

from __future__ import annotations

import io
import os
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import toolchain
from cosim.errors import SimulationError
from cosim.result import Array


@dataclass(frozen=True)
class Checkpoint:
    """What is needed to go on with a run in another process.

    Attributes
    ----------
    identity : what must be the same for the run to go on: times, coupling, signals and FMUs
    step : number of steps done
    row : all signals at that time, then the sums of squares up to there
    states : component -> state of its FMU
    starts : start values that are numbers, to which a scenario may go back
    memory : what the coupling and facades remember: ``component/name``, of the coupling ``/name``
    """

    identity: str
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
        np.savez(stream, identity=self.identity, step=self.step, row=self.row, **arrays)
        return toolchain.write_whole(Path(path), stream.getvalue())

    def memory_of(self, owner: str) -> dict[str, Array]:
        """Return what a component's facade remembers, or the coupling, whose name is empty."""
        parts = ((name.rpartition("/"), values) for name, values in self.memory.items())
        return {name: values for (component, _, name), values in parts if component == owner}

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Checkpoint:
        """Read a file.

        Raises
        ------
        SimulationError
            When it cannot be read or is no saved state.
        """
        try:
            with np.load(path, allow_pickle=False) as arrays:
                kinds: dict[str, dict[str, Array]] = {"state": {}, "start": {}, "memory": {}}
                for key in arrays.files:
                    kind, _, name = key.partition(":")
                    kinds.get(kind, {})[name] = arrays[key]
                states = {name: state.tobytes() for name, state in kinds["state"].items()}
                starts = {name: float(start) for name, start in kinds["start"].items()}
                identity, step = str(arrays["identity"]), int(arrays["step"])
                return cls(identity, step, arrays["row"], states, starts, kinds["memory"])
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as fault:
            raise SimulationError(f"{path}: no saved state that can be read: {fault}") from fault
