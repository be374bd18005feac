"""The velocity filter against the exact motion of an axis, by the matrix exponential."""

import numpy as np
import pytest
from scipy.linalg import expm

NAME = "velocity_filter"
T_S = 5e-4  # s
AXES = [(5.557, 6.6135, 1e-4), (5.557, 0.0, 1e-4), (0.5, 900.0, 2e-3), (12.0, 6.6, 0.0)]


def motion(axis, u, friction=None, d=None):
    """Return x, v, F_m (n,) under held commands, friction behind the same lag, and a force d."""
    m, b, tau_i = axis
    n = len(u)
    friction, d = (np.zeros(n) if values is None else values for values in (friction, d))
    rates = np.zeros((7, 7))  # x, v, F, friction, then what is held: u, friction commanded, d
    rates[0, 1] = 1.0
    rates[1, 1], rates[1, 6] = -b / m, 1.0 / m
    rates[1, [2, 3]] = np.array([1.0, -1.0]) / m
    if tau_i > 0.0:
        rates[2, [2, 4]] = rates[3, [3, 5]] = -1.0 / tau_i, 1.0 / tau_i
    move = expm(rates * T_S)
    states = [np.zeros(4)]
    for held in zip(u[:-1], friction[:-1], d[:-1], strict=True):
        begin = states[-1] if tau_i > 0.0 else [*states[-1][:2], *held[:2]]
        states.append((move @ [*begin, *held])[:4])
    x, v, F_m, _ = np.transpose(states)
    return x, v, F_m


def estimate(alone, axis, inputs, **gains):
    n = len(inputs["x_enc"])
    parameters = dict(zip(("m", "b", "tau_i"), axis, strict=True)) | gains
    record = tuple(f"{NAME}.{name}" for name in ("v_hat", "d_hat"))
    with alone(NAME, record, step=T_S, stop=n * T_S) as simulation:
        result = simulation.run(
            inputs={name: np.append(values, values[-1]) for name, values in inputs.items()},
            parameters={f"{NAME}.{name}": value for name, value in parameters.items()},
        )
    return result[record[0]][1:], result[record[1]][1:]


def force(n):
    rng = np.random.default_rng(3)
    return 30.0 * np.repeat(rng.normal(size=n // 5), 5)


@pytest.mark.parametrize("axis", AXES, ids=str)
def test_without_disturbance_it_knows_the_velocity(alone, axis):
    """At once and to rounding, whatever force moves the axis, known friction and place included."""
    u = force(1000)
    friction = 6.0 * np.sign(np.repeat(np.random.default_rng(4).normal(size=100), 10))
    x, v, F_m = motion(axis, u, friction)
    v_hat, d_hat = estimate(alone, axis, {"x_enc": x + 0.3, "F_m": F_m, "F_ff": friction})
    np.testing.assert_allclose(v_hat, v, rtol=0, atol=1e-9)
    assert abs(d_hat).max() < 1e-4
    untold, _ = estimate(alone, axis, {"x_enc": x, "F_m": F_m})
    assert abs(untold - v).max() > 1e-4
