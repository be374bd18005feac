"""Inputs that jump do so at their time, whatever the coupling and however large the times are."""

import numpy as np
import pytest

from stickslip.cosim import Adaptive, Coupling, Table
from tests.cosim.single import joined, one

KINDS = {
    "CS 2.0 interpolating": (2, {}),
    "CS 3.0": (3, {}),
    "ME 2.0": (2, {"exchange": True}),
    "ME 3.0": (3, {"exchange": True}),
}
COUPLINGS = {
    f"{method}, degree {degree}": Coupling(method, degree=degree)
    for method in ("gauss_seidel", "jacobi", "iterative")
    for degree in (0, 1, 2)
}
ADAPTIVE = {
    f"adaptive, degree {degree}": Coupling("iterative", degree=degree, adaptive=Adaptive(1e-4))
    for degree in (1, 2)
}
STARTS = {"0": (0.0, 0.1), "1e4": (1e4, 1e-5), "Unix": (1.7e9, 1e-3)}
N = 20
LEVELS = np.array([0.5, -2.0, 3.0, 1.0])
AT = np.array([0, 3, 7, 15])  # the points in time at which they begin
each_kind = pytest.mark.parametrize("kind", KINDS)
BEYOND_0 = [name for name in COUPLINGS | ADAPTIVE if "degree 0" not in name]


def at_each_start(couplings):
    """All couplings from 0 on, one of each degree from large times on."""
    some = [name for name in couplings if name.startswith("iterative")]
    pairs = [(name, "0") for name in couplings] + [(n, s) for n in some for s in ("1e4", "Unix")]
    return pytest.mark.parametrize(("coupling", "start"), pairs)


def integrator(linear, kind):
    """x' = u, y1 = x."""
    version, abilities = KINDS[kind]
    return one(linear(version, **abilities), {"b11": 1.0, "c11": 1.0}, "u1")


def run(system, coupling, start, step, signal, **more):
    how = (COUPLINGS | ADAPTIVE)[coupling]
    spec = {"start": start, "step": step, "stop": start + N * step, "tolerance": 1e-9}
    with system.prepare(**spec, coupling=how) as simulation:
        return simulation.run(inputs={"u": signal} if system.inputs else {}, **more)


def levels(start, step):
    """Return the times of the jumps, as whoever writes the table computes them, and the input."""
    time = np.array([start + k * step for k in AT])
    u = np.repeat(LEVELS, np.diff([*AT, N + 1]))
    return time, u


@each_kind
@at_each_start(COUPLINGS | ADAPTIVE)
def test_a_held_input_is_held(linear, kind, coupling, start):
    """Each value from its time on: the integral is a sum of rectangles."""
    start, step = STARTS[start]
    time, u = levels(start, step)
    result = run(integrator(linear, kind), coupling, start, step, Table(time, LEVELS, held=True))
    np.testing.assert_array_equal(result["u"], u)
    exact = step * np.append(0.0, np.cumsum(u[:-1]))
    np.testing.assert_allclose(result["a.y1"], exact, rtol=2e-3 if start else 1e-7, atol=step / 200)


@each_kind
@at_each_start(BEYOND_0)
def test_lines_that_jump_end_where_the_next_begins(linear, kind, coupling, start):
    """A sawtooth with its corners on points of the run: the integral is a sum of trapezoids."""
    start, step = STARTS[start]
    teeth = np.array([0, 4, 4, 8, 8, 12, 12, 16, 16, 20])
    table = Table([start + k * step for k in teeth], [0.0, 1.0] * 5)
    result = run(integrator(linear, kind), coupling, start, step, table)
    rise = np.arange(N + 1) % 4 / 4
    exact = step * np.append(0.0, np.cumsum(rise[:-1] + 1 / 8))
    np.testing.assert_allclose(result["u"][:-1], rise[:-1], atol=1e-12 if not start else 1e-3)
    np.testing.assert_allclose(result["a.y1"], exact, rtol=2e-3 if start else 1e-7, atol=step / 200)


@each_kind
@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("method", ["gauss_seidel", "jacobi"])
def test_jumps_between_points_are_where_they_are(linear, kind, start, method):
    start, step = STARTS[start]
    system = integrator(linear, kind)
    jump = start + 3 * step + np.ldexp(np.round(np.ldexp(step / 4, 22)), -22)  # a binary number
    table = Table([start, jump], [0.0, 1.0], held=True)
    result = run(system, f"{method}, degree 0", start, step, table)
    exact = np.maximum(result.time - jump, 0.0)
    np.testing.assert_allclose(result["a.y1"], exact, atol=step * (2e-3 if start else 1e-6))


@each_kind
@pytest.mark.parametrize("start", STARTS)
def test_adaptive_steps_come_past_a_jump_at_any_time(linear, kind, start):
    """An output that shows the jump at once lets no prediction hold, however short the step."""
    start, step = STARTS[start]
    version, abilities = KINDS[kind]
    gain = linear(version, "d11", **abilities), {"d11": 1.0}
    parts = {"gain": gain, "a": (linear(version, **abilities), {"b11": 1.0, "c11": 1.0})}
    system = joined(parts, "gain.y1 a.u1", u="gain.u1")
    time, u = levels(start, step)
    coupling = "adaptive, degree 1"
    result = run(system, coupling, start, step, Table(time, LEVELS, held=True))
    exact = step * np.append(0.0, np.cumsum(u[:-1]))
    np.testing.assert_allclose(result["a.y1"], exact, rtol=2e-3, atol=step / 50)
