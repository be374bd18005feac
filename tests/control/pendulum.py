"""The pendulum of pendulum.c as an FMU of Model Exchange, and its linearisation by hand."""

from pathlib import Path

import numpy as np

from tests.corpus import fmu
from tests.corpus.fmu import Variable

_VARIABLES = [
    Variable("theta", "local", 0.0, initial="exact"),
    Variable("omega", "local", 0.0, initial="exact"),
    Variable("torque", "input", 0.0),
    Variable("k", "parameter", 9.81),
    Variable("drag", "parameter", 0.0),
    Variable("x", "output"),
    Variable("power", "output"),
    Variable("der(theta)", derivative="theta"),
    Variable("der(omega)", derivative="omega"),
]


def pendulum(folder: Path, version: int, derivatives: bool) -> Path:
    """Write the FMU; with ``derivatives`` it declares its directional derivatives."""
    library = fmu.library("pendulum", Path(__file__).with_name("pendulum.c"))
    plural = "s" if version == 3 else ""
    flag = f'providesDirectionalDerivative{plural}="true"' if derivatives else ""
    description = fmu.describe("pendulum", version, _VARIABLES, {"ModelExchange": flag})
    path = folder / f"pendulum{version}{derivatives:d}.fmu"
    return fmu.pack(path, description, {fmu.place("pendulum", version): library.read_bytes()})


def by_hand(theta: float, omega: float, torque: float, k: float, drag: float):
    """Return A, B, C, D of the pendulum at a point."""
    A = np.array([[0.0, 1.0], [-k * np.cos(theta), -2 * drag * abs(omega)]])
    C = np.array([[np.cos(theta), 0.0], [0.0, torque]])
    return A, np.array([[0.0], [1.0]]), C, np.array([[0.0], [omega]])
