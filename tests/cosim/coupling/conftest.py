"""FMUs of linear systems, exact within a step, and two masses coupled by a spring and a damper."""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path

import fmpy
import numpy as np
import pytest

from stickslip import cosim
from stickslip.fmi import toolchain

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
    variables, outputs = [], []
    for reference, name in enumerate(NAMES):
        causality = {"u": "input", "y": "output"}.get(name[0], "parameter")
        common = f'name="{name}" valueReference="{reference}" causality="{causality}"'
        start = "" if causality == "output" else 'start="0"'
        if version == 2:
            kind = 'variability="fixed"' if causality == "parameter" else ""
            variables.append(f"<ScalarVariable {common} {kind}><Real {start}/></ScalarVariable>")
        else:
            kind = 'variability="fixed"' if causality == "parameter" else ""
            variables.append(f"<Float64 {common} {kind} {start}/>")
        if causality == "output":
            used = [j for j in (1, 2) if f"d{name[1]}{j}" in feedthrough]
            if version == 2:
                outputs.append(f'<Unknown index="{reference + 1}" dependencies="{_list(used)}"/>')
            else:
                used = [j - 1 for j in used]
                outputs.append(
                    f'<Output valueReference="{reference}" dependencies="{_list(used)}"/>'
                )
    rates = []
    for i in (1, 2) if exchange else ():  # the states, under names of their own
        index, state, rate = len(variables) + 2, 40 + i, 50 + i
        local = 'causality="local" variability="continuous"'
        if version == 2:
            entry = '<ScalarVariable name="{}" valueReference="{}" {}><Real {}/></ScalarVariable>'
            variables += [entry.format(f"s{i}", state, local, "")]
            variables += [entry.format(f"der(s{i})", rate, local, f'derivative="{index - 1}"')]
            rates.append(f'<Unknown index="{index}"/>')
        else:
            variables += [f'<Float64 name="s{i}" valueReference="{state}" {local}/>']
            variables += [
                f'<Float64 name="der(s{i})" valueReference="{rate}" {local} derivative="{state}"/>'
            ]
            rates.append(f'<ContinuousStateDerivative valueReference="{rate}"/>')
    if version == 3:
        variables.append(
            '<Float64 name="time" valueReference="99" causality="independent"'
            ' variability="continuous"/>'
        )
        structure = "".join(outputs + rates)
        head = 'fmiVersion="3.0" instantiationToken="linear"'
    else:
        structure = f"<Outputs>{''.join(outputs)}</Outputs>"
        structure += f"<Derivatives>{''.join(rates)}</Derivatives>" if rates else ""
        head = 'fmiVersion="2.0" guid="linear"'
    flags = " ".join(f'{name}="{str(can).lower()}"' for name, can in abilities.items())
    varies = ' canHandleVariableCommunicationStepSize="true"'
    kind = "ModelExchange" if exchange else "CoSimulation"
    return (
        f'<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription {head} modelName="linear">'
        f'<{kind} modelIdentifier="linear" {flags}{"" if exchange else varies}/>'
        f"<ModelVariables>{''.join(variables)}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )


def _list(numbers: list[int]) -> str:
    return " ".join(map(str, numbers))


@pytest.fixture(scope="session")
def linear(tmp_path_factory: pytest.TempPathFactory) -> Linear:
    """Make an FMU: ``linear(2, "d11", restores=False)``: y1 depends on u1 at once, no way back."""
    folder = tmp_path_factory.mktemp("linear")
    made: dict[object, Path] = {}

    def make(
        version: int = 2,
        *feedthrough: str,
        restores: bool = True,
        interpolates: bool = True,
        exchange: bool = False,
        flags: tuple[str, ...] = (),
    ) -> Path:
        key = (version, feedthrough, restores, interpolates, exchange, flags)
        if key not in made:
            headers = Path(fmpy.__file__).parent / "c-code"
            files = {f"system/{h.name}": h.read_text() for h in headers.glob("fmi[23]*.h")}
            files["linear.c"] = Path(__file__).with_name("linear.c").read_text()
            binary = toolchain.shared_library("linear", files, flags=flags)
            platform = toolchain.host_platform()
            place = platform.fmi2 if version == 2 else platform.tuple
            word = "FMUstate" if version == 2 else "FMUState"
            abilities = {f"canGetAndSet{word}": restores, f"canSerialize{word}": restores}
            if version == 2 and not exchange:
                abilities["canInterpolateInputs"] = interpolates
            path = folder / f"{len(made)}.fmu"
            with zipfile.ZipFile(path, "w") as archive:
                text = describe(version, frozenset(feedthrough), abilities, exchange=exchange)
                archive.writestr("modelDescription.xml", text)
                archive.write(binary, f"binaries/{place}/{binary.name}")
            made[key] = path
        return made[key]

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

    def system(self, linear: Linear, version: int = 2, **abilities: bool) -> cosim.System:
        system = cosim.System("two masses")
        system.add("left", linear(version, **abilities), self.left)
        system.add("right", linear(version, "d11", "d12", **abilities), self.right)
        system.connect("left.y1", "right.u1")
        system.connect("left.y2", "right.u2")
        system.connect("right.y1", "left.u1")
        return system


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
