"""Loops without delay are solved where FMUs can repeat a step, and named where they cannot."""

import gc
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from stickslip import cosim
from tests.cosim.single import joined


@pytest.fixture
def gains(linear, version):
    """a = k1 b + w + 0.7, b = k2 a, all at once."""

    def make(k1, k2, **abilities):
        first = {"d11": k1, "d12": 1.0, "f1": 0.7}
        a, b = linear(version, "d11", "d12", **abilities), linear(version, "d11", **abilities)
        return joined({"a": (a, first), "b": (b, {"d11": k2})}, "a.y1 b.u1", "b.y1 a.u1", w="a.u2")

    return make


@pytest.mark.parametrize("method", ["gauss_seidel", "iterative"])
@pytest.mark.parametrize(("k1", "k2"), [(0.5, 0.5), (2.0, 3.0), (-4.0, 5.0), (1.0, 0.999)])
def test_two_gains_have_their_exact_solution_at_every_step(gains, k1, k2, method):
    with gains(k1, k2).prepare(step=1e-2, stop=2.0, coupling=method) as simulation:
        w = np.sin(7.0 * simulation.time)
        result = simulation.run(inputs={"w": w})
    if method == "gauss_seidel":
        w = np.concatenate([w[:1], w[:-1]])  # held from the begin of the step
    exact = (0.7 + w) / (1.0 - k1 * k2)
    scale = np.abs(exact).max() / abs(1.0 - k1 * k2)  # of rounding errors
    np.testing.assert_allclose(result["a.y1"], exact, rtol=0, atol=1e-12 * max(scale, 1.0))
    np.testing.assert_allclose(result["b.y1"], k2 * exact, rtol=0, atol=1e-12 * max(scale, 1.0))


@pytest.mark.parametrize(
    ("method", "restores"),
    [("gauss_seidel", True), ("jacobi", True), ("jacobi", False), ("iterative", True)],
)
def test_initial_values_agree_whatever_the_coupling(gains, method, restores):
    """Before the first step nothing has to be taken back."""
    system = gains(2.0, 3.0, restores=restores)
    result = system.prepare(step=1e-2, stop=0.1, coupling=method).run(inputs={"w": 0.3})
    assert result["a.y1"][0] == pytest.approx(1.0 / (1.0 - 6.0), abs=1e-12)


def test_iteration_names_who_cannot_go_back(linear, two_masses):
    system = two_masses.system(linear, restores=False)
    with pytest.raises(cosim.ConnectionFault, match=r"'iterative' repeats.*right \(.*left \("):
        system.prepare(step=0.1, stop=1.0, coupling="iterative")


@pytest.mark.parametrize(("off", "noticed"), [(1e-8, False), (1e-4, True)])
def test_a_state_that_comes_back_a_little_off_is_noticed(two_masses, linear, version, off, noticed):
    flags = (f"-DRESTORED=(((Model*)m)->x[0]+={off})",)
    system = two_masses.system(linear, version, flags=flags)
    with system.prepare(step=0.1, stop=1.0, coupling="iterative") as simulation:
        if noticed:
            with pytest.raises(cosim.SimulationError, match="did not bring back the state"):
                simulation.run()
        else:
            simulation.run()


def test_a_loop_without_solution_is_named_with_its_worst_variable(gains):
    with (
        gains(1.0, 1.0).prepare(step=0.1, stop=1.0) as simulation,
        pytest.raises(cosim.SimulationError, match=r"loop .*a\.y1.*b\.y1 changed last by 0\.7"),
    ):
        simulation.run()


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6])
def test_what_is_found_is_within_the_tolerance_where_the_loop_is_nearly_singular(gains, tolerance):
    """a = 0.7 + w + w^3 c + a + c a^3: the slope of the right side in a is nearly 1."""
    c = -1e-4
    coupling = cosim.Coupling("iterative", tolerance=tolerance)
    with gains(1.0, 1.0).prepare(step=1e-2, stop=2.0, coupling=coupling) as simulation:
        w = np.sin(9.0 * simulation.time)
        result = simulation.run({"a.cubic": c}, inputs={"w": w})["a.y1"][1:]
    exact = np.cbrt(-(0.7 + w + c * w**3) / c)[1:]
    error = abs(result - exact) / np.maximum(abs(exact), 1.0)
    assert error.max() < 1.2 * tolerance


def test_more_iterations_than_allowed_are_not_done(gains):
    """The least number that solves a step is that which is done where many more are allowed."""

    def sweeps(most):
        coupling = cosim.Coupling("iterative", max_iterations=most)
        with gains(-1.0, 1.0).prepare(step=1.0, stop=1.0, coupling=coupling) as simulation:
            try:
                simulation.run({"a.cubic": 1.0}, inputs={"w": np.array([0.0, 30.0])})
            except cosim.SimulationError:
                return 0
            return simulation.effort["sweeps"]

    solved = [sweeps(most) for most in range(1, 40)]
    least = 1 + next(i for i, n in enumerate(solved) if n)
    done = sweeps(1000)
    assert set(solved) == {0, done}
    assert done / 3 < least <= done  # further sweeps find Jacobians and the length of a step


def test_a_cycle_of_components_that_is_no_loop_of_variables(linear):
    """a.u1 -> a.y1 -> b -> a.u2 -> a.y2: through a twice, but never back."""

    def chain(**abilities):
        a = linear(2, "d11", "d22", **abilities), {"d11": 2.0, "d22": 3.0}
        b = linear(2, "d11", **abilities), {"d11": 5.0}
        return joined({"a": a, "b": b}, "a.y1 b.u1", "b.y1 a.u2", w="a.u1")

    w = np.arange(6.0)
    result = chain().prepare(step=1.0, stop=5.0).run(inputs={"w": w})
    np.testing.assert_allclose(result["a.y2"][1:], 30.0 * w[:-1], rtol=1e-15)
    result = chain(restores=False).prepare(step=1.0, stop=5.0).run(inputs={"w": w})
    np.testing.assert_allclose(result["a.y2"][2:], 30.0 * w[:-2], rtol=1e-15)  # a step late


@pytest.mark.slow
def test_many_runs_leave_memory_and_open_files_as_they_were(two_masses, linear):
    if not Path("/proc/self/statm").exists():
        pytest.skip("needs /proc")

    def resources():
        gc.collect()
        files = len([*Path("/proc/self/fd").iterdir()])
        return int(Path("/proc/self/statm").read_text().split()[1]), files

    def prepare():
        return two_masses.system(linear).prepare(step=0.1, stop=1.0, coupling="iterative")

    with prepare() as simulation:
        for _ in range(200):
            simulation.run()
        before, files = resources()
        for k in range(3000):
            simulation.run({"left.e1": k / 3000})
    for _ in range(50):
        prepare().close()
    assert resources()[1] == files
    assert resources()[0] - before < 100


def test_a_value_that_is_not_finite_is_blamed_not_the_loop(gains):
    with gains(-1.0, 1.0).prepare(step=0.1, stop=1.0, coupling="iterative") as simulation:
        w = np.where(simulation.time > 0.45, 1e200, 0.0)
        with pytest.raises(cosim.SimulationError, match=r"a\.y1: .*not finite .* t = 0\.4 s"):
            simulation.run({"a.cubic": 1.0}, inputs={"w": w})


@pytest.mark.parametrize(
    "wrong",
    [
        {"method": "newton"}, {"degree": 3}, {"tolerance": 0.0}, {"max_iterations": 0},
        {"every": {"a": 0}}, {"every": {"a": 2}, "degree": 1},
    ],
)  # fmt: skip
def test_impossible_couplings_are_refused(wrong):
    with pytest.raises(cosim.CosimError):
        cosim.Coupling(**wrong)


def fixed_point(function):
    """Return a run of a loop of two functions, where y = function(y)."""
    parts = {
        name: cosim.Function(lambda _, u, f=called: f(u["u"]), {"u": None}, {"y": None})
        for name, called in (("a", function), ("b", float))
    }
    return joined(parts, "a.y b.u", "b.y a.u").prepare(step=0.1, stop=0.2).run()


@pytest.mark.parametrize(
    ("equation", "root"),
    [
        (lambda w: np.arctan(w - 10.0), 10.0),  # Newton overshoots further with each step
        (lambda w: np.arctan(50.0 * w + 100.0), -2.0),
        (lambda w: np.arcsinh(1e3 * (w - 3.0)), 3.0),
        (lambda w: np.sign(w - 4.0) * np.log1p(abs(w - 4.0)), 4.0),
        (lambda w: np.log(max(0.0, 1.0 + w)) - 2.5 if w > -1.0 else np.nan, np.exp(2.5) - 1.0),
    ],
)
def test_a_loop_with_one_root_of_a_monotone_equation_is_solved_from_afar(equation, root):
    result = fixed_point(lambda w: w - equation(w))
    np.testing.assert_allclose(result["b.y"], root, rtol=1e-9)


@pytest.mark.parametrize("height", [5.0, 50.0, 1000.0])
@pytest.mark.parametrize("slope", [10.0, 1000.0])
def test_a_loop_that_falls_steeply_between_saturations_is_solved(height, slope):
    """Where saturation sends Newton's method across the step, again and again; the output is that
    at the solution, not beside it."""

    def falling(x: float) -> float:
        return float(1.0 - height * np.arctan(slope * (x + 20.0)))

    root = brentq(lambda x: x - falling(x), -1e4, 1e4, xtol=1e-13, rtol=1e-15)
    result = fixed_point(falling)
    np.testing.assert_allclose(result["a.y"], root, rtol=2e-8 * slope * height / 1e6)
