"""FMUs of linear systems, exact within a step, and two masses coupled by a spring and a damper."""

import functools
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

from stickslip import cosim
from tests.corpus import fmu
from tests.corpus.fmu import Variable
from tests.cosim.single import joined

SIGNALS = ["u1", "u2", "x1", "x2", "y1", "y2"]
MATRICES = [f"{m}{i}{j}" for m in "abcd" for i in (1, 2) for j in (1, 2)]
NAMES = [*SIGNALS, *MATRICES, "e1", "e2", "f1", "f2", "cubic"]
Linear = Callable[..., Path]


def describe(
    version: int,
    feedthrough: frozenset[str],
    abilities: Mapping[str, bool],
    *,
    exchange: bool = False,
) -> str:
    """Return modelDescription.xml; ``feedthrough`` names the elements of D that count.

    ``exchange`` describes Model Exchange in the place of Co-Simulation.
    """
    variables = []
    for name in NAMES:
        causality = {"u": "input", "y": "output"}.get(name[0], "parameter")
        if causality == "output":
            used = [f"u{j}" for j in (1, 2) if f"d{name[1]}{j}" in feedthrough]
            variables.append(Variable(name, causality, depends=used))
        else:
            variables.append(Variable(name, causality, 0))
    for i in (1, 2) if exchange else ():  # the states, under names of their own
        variables.append(Variable(f"s{i}", reference=40 + i))
        variables.append(Variable(f"der(s{i})", reference=50 + i, derivative=f"s{i}"))
    flags = " ".join(f'{name}="{str(can).lower()}"' for name, can in abilities.items())
    varies = ' canHandleVariableCommunicationStepSize="true"'
    interface = {"ModelExchange": flags} if exchange else {"CoSimulation": flags + varies}
    return fmu.describe("linear", version, variables, interface)


@pytest.fixture(scope="session")
def linear(tmp_path_factory: pytest.TempPathFactory) -> Linear:
    """Make an FMU: ``linear(2, "d11", restores=False)``: y1 depends on u1 at once, no way back."""
    folder = tmp_path_factory.mktemp("linear")

    @functools.cache
    def make(
        version: int = 2,
        *feedthrough: str,
        restores: bool = True,
        interpolates: bool = True,
        exchange: bool = False,
        flags: tuple[str, ...] = (),
    ) -> Path:
        word = "FMUstate" if version == 2 else "FMUState"
        abilities = {f"canGetAndSet{word}": restores, f"canSerialize{word}": restores}
        if version == 2 and not exchange:
            abilities["canInterpolateInputs"] = interpolates
        source = Path(__file__).with_name("linear.c")
        library = fmu.library("linear", source, flags=flags, complete=False)
        text = describe(version, frozenset(feedthrough), abilities, exchange=exchange)
        path = Path(tempfile.mkdtemp(dir=folder)) / "linear.fmu"
        return fmu.pack(path, text, {fmu.place("linear", version): library.read_bytes()})

    return make


class TwoMasses:
    """Two masses between walls, coupled by a spring and a damper, at rest until let go.

    The left FMU is one mass on its spring; force in, place and speed out. The right one is the
    other mass and the coupling; place and speed of the left in, force out, without delay.
    """

    def __init__(self, m: tuple[float, float], k: tuple[float, float, float], d: float) -> None:
        (m1, m2), (k1, k2, kc) = m, k
        self.left = {"a12": 1.0, "a21": -k1 / m1, "b21": 1 / m1, "c11": 1.0, "c22": 1.0, "x1": 1.0}
        self.right = {"a12": 1.0, "a21": -(k2 + kc) / m2, "a22": -d / m2, "b21": kc / m2}
        self.right |= {"b22": d / m2, "c11": kc, "c12": d, "d11": -kc, "d12": -d}
        self.matrix = np.array(
            [
                [0, 1, 0, 0],
                [-(k1 + kc) / m1, -d / m1, kc / m1, d / m1],
                [0, 0, 0, 1],
                [kc / m2, d / m2, -(k2 + kc) / m2, -d / m2],
            ]
        )

    def exact(self, time: np.ndarray) -> np.ndarray:
        """Return the places of the left mass (n,), m, at times a step apart from 0 on."""
        once = expm(self.matrix * time[1])
        states = [np.array([1.0, 0.0, self.right.get("x1", 0.0), 0.0])]
        for _ in time[1:]:
            states.append(once @ states[-1])
        return np.array(states)[:, 0]

    def system(self, linear: Linear, version: int = 2, **abilities: bool) -> cosim.System:
        left = linear(version, **abilities), self.left
        right = linear(version, "d11", "d12", **abilities), self.right
        wires = "left.y1 right.u1", "left.y2 right.u2", "right.y1 left.u1"
        return joined({"left": left, "right": right}, *wires)


@pytest.fixture
def two_masses() -> TwoMasses:
    """Hertz and less, weakly damped."""
    return TwoMasses((1.0, 2.0), (10.0, 15.0, 20.0), 0.3)


@pytest.fixture
def stiff_pair() -> TwoMasses:
    """A light mass on a hard coupling, both let go at the same height."""
    pair = TwoMasses((1.0, 0.1), (10.0, 10.0, 1e4), 20.0)
    pair.right["x1"] = 1.0
    return pair


@pytest.fixture
def transient_pair() -> TwoMasses:
    """A light mass that settles within milliseconds, then a slow swing of both."""
    return TwoMasses((1.0, 0.02), (1.0, 1.0, 2000.0), 20.0)
