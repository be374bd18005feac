"""What compensators learn in a run, and take over to the next."""

import numpy as np
import pytest

from stickslip import models
from stickslip.cosim import ParameterError, SimulationError
from tests.cosim.single import exposed

T = 2.0**-11  # s; times and positions of the tests are not rounded
LEARNERS = [
    name
    for name in models.model_names()
    if (ports := models.load_model(name).ports) and ports.learned
]


@pytest.fixture(scope="module")
def fmus_3(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fmi3")
    for name in LEARNERS:
        models.build_fmu(name, folder, fmi=3)
    return folder


def motion(n: int) -> np.ndarray:
    """Return velocities (n,) that go to and fro and end forward."""
    t = np.arange(n) * T
    return np.round(2.0**9 * 0.1 * np.sin(4.5 * np.pi * t / t[-1])) / 2.0**9


def signals(v: np.ndarray, friction: float = 5.0) -> dict[str, np.ndarray]:
    """Return inputs of any compensator for velocities (n,) of the reference."""
    F = np.append(0.0, (friction * np.sign(v) + np.diff(np.append(v[0], v)) / T)[:-1])
    x = np.append(0.0, np.cumsum(v)[:-1]) * T
    return {"v_r": v, "x_enc": x, "F_m": F, "u": F, "F_in": 4.0 * np.sign(v)}


def simulation(fmu, n, **options):
    times = {"step": T, "stop": T * (n - 1), "constant_step": True}
    return exposed(fmu, name="c").prepare(**times, **options)


def inputs(prepared, given):
    return {name: given[name] for name in prepared.spec.system.inputs}


@pytest.mark.parametrize("name", LEARNERS)
def test_what_is_learned_starts_the_next_run_bit_for_bit(fmus, fmus_3, name):
    """The same in FMI 2.0, FMI 3.0 and a process of its own; a run without it begins untrained."""
    ways = [(fmus, None), (fmus_3, None), *([(fmus, "process")] if name == "lffc" else [])]
    n = 1000
    moving, still = signals(motion(n)), signals(np.zeros(n))
    found = []
    for folder, isolation in ways:
        with simulation(folder / f"{name}.fmu", n, isolation=isolation) as prepared:
            prepared.run(inputs=inputs(prepared, still))
            untrained = prepared.learned()
            prepared.run(inputs=inputs(prepared, moving))
            found.append(prepared.learned())
            prepared.run(found[-1], inputs(prepared, still))
            assert prepared.learned() == found[-1]
            prepared.run(inputs=inputs(prepared, still))
            assert prepared.learned() == untrained
    assert all(learned == found[0] for learned in found)
    assert any(found[0][key] != untrained[key] for key in untrained)


def test_values_are_those_at_the_end(fmus):
    with simulation(fmus / "lffc.fmu", 100) as prepared:
        with pytest.raises(SimulationError, match=r"c.gamma has no value yet: run first"):
            prepared.values(["c.gamma"])
        result = prepared.run(
            {"c.gamma": 0.125, "c.T_s": T}, inputs(prepared, signals(motion(100)))
        )
        found = prepared.values(["c.F", "c.gamma", "c.D", "c.k"])
        assert found == [result["c.F"][-1], 0.125, 8.0, 99.0]
        with pytest.raises(ParameterError, match="no variable 'gama'; did you mean"):
            prepared.values(["c.gama"])


def test_an_fmu_that_learns_nothing_says_so(fmus):
    with simulation(fmus / "static_feedforward.fmu", 10) as prepared:
        prepared.run(inputs={"v": np.zeros(10), "F_in": np.zeros(10)})
        assert prepared.learned() == {}
