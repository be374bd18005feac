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
    """

    identity: str
    step: int
    row: Array
    states: Mapping[str, bytes]

    def write(self, path: str | os.PathLike[str]) -> Path:
        """Write a file."""
        stream = io.BytesIO()
        arrays: dict[str, Any] = {
            f"state:{name}": np.frombuffer(state, np.uint8) for name, state in self.states.items()
        }
        np.savez(stream, identity=self.identity, step=self.step, row=self.row, **arrays)
        return toolchain.write_whole(Path(path), stream.getvalue())

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
                states = {
                    name.removeprefix("state:"): arrays[name].tobytes()
                    for name in arrays.files
                    if name.startswith("state:")
                }
                return cls(str(arrays["identity"]), int(arrays["step"]), arrays["row"], states)
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as fault:
            raise SimulationError(f"{path}: no saved state that can be read: {fault}") from fault
