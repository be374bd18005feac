"""What compensators learn in a run, and take over to the next."""

import numpy as np
import pytest

from stickslip import cosim, models
from stickslip.cosim import ParameterError, SimulationError
from tests.cosim.single import exposed

T = 2.0**-11  # s; times and positions of the tests are not rounded
LEARNERS = [
    name
    for name in models.model_names()
    if (ports := models.load_model(name).ports) and ports.learned
]
EXACT = {"T_s": T, "m": 1.0, "b": 0.0, "lead": 0.0}


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
    n = 1000
    moving, still = signals(motion(n)), signals(np.zeros(n))
    found = []
    for folder, isolation in ((fmus, None), (fmus_3, None), (fmus, "process")):
        with simulation(folder / f"{name}.fmu", n, isolation=isolation) as prepared:
            prepared.run(inputs=inputs(prepared, still))
            untrained = prepared.learned()
            prepared.run(inputs=inputs(prepared, moving))
            found.append(prepared.learned())
            prepared.run(found[-1], inputs(prepared, still))
            assert prepared.learned() == found[-1]
            prepared.run(inputs=inputs(prepared, still))
            assert prepared.learned() == untrained
    assert found[0] == found[1] == found[2]
    assert any(found[0][key] != untrained[key] for key in untrained)


CASES = {
    "lffc": ({"D": 0}, "gamma"),
    "rbf": ({"D": 0}, "gamma"),
    "mlp": ({"D": 0}, "gamma"),
    "adaptive_scale": ({"tau_f": 0.0, "tau_i": 0.0, "rate": 5.0}, "rate"),
}
"""Parameters, and that of the rate of learning."""


@pytest.mark.parametrize("name", CASES)
def test_two_runs_are_one_without_an_interruption(fmus, name):
    """Where the rest of the state is the same: after a rest, in the other direction."""
    own, rate = CASES[name]
    start = {v.name: v.start for v in models.load_model(name).variables}
    parameters = {f"c.{key}": x for key, x in {**EXACT, **own}.items() if key in start}
    learning, switch, few = own.get(rate, start[rate]), f"c.{rate}", 6
    n, rest = 2000, 40
    whole = np.concatenate([motion(n), np.zeros(rest), -motion(n)])
    begin = n + rest - 1  # of the second run: a sample of the rest
    with simulation(fmus / f"{name}.fmu", len(whole)) as prepared:
        given = inputs(prepared, signals(whole))
        times = np.array([0, n - 1, begin + few]) * T
        pause = {switch: cosim.Table(times, [learning, 0.0, learning], held=True)}
        whole_run = prepared.run(parameters, given, tunable=pause)["c.F"][begin + few :]
    with simulation(fmus / f"{name}.fmu", n) as prepared:
        prepared.run(parameters, {key: x[:n] for key, x in given.items()})
        kept = prepared.learned()
    with simulation(fmus / f"{name}.fmu", n + 1) as prepared:
        later = {key: x[begin:] for key, x in given.items()}
        pause = {switch: cosim.Table([0.0, few * T], [0.0, learning], held=True)}
        second, untrained = (
            prepared.run({**parameters, switch: 0.0, **weights}, later, tunable=pause)["c.F"][few:]
            for weights in (kept, {})
        )
    assert second.tobytes() == whole_run.tobytes()
    assert untrained.tobytes() != whole_run.tobytes()


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
