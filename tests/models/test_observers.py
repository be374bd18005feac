"""Observers of friction: identities, convergence, a loop without friction, orders."""

import numpy as np
import pytest
from scipy.linalg import expm

from stickslip import cosim, models
from stickslip.servo.axis import Axis
from stickslip.servo.velocity_filter import FilterSpecification, Observer, design_velocity_filter

T = 5e-4  # s
PLAIN = {"tau_f": 0.0, "tau_i": 0.0, "b": 0.0, "m": 1e-6}
"""A momentum observer whose residual is the motor force."""


def test_the_error_of_the_amplitude_decays_with_a_power_of_the_speed(observe):
    """a_hat = 1 - exp(-(k mu / m)(t + (1 - cos t) / 2)) for v = 1 + sin(t) / 2 and mu = 2."""
    t = np.arange(2001) * T
    v, k, mu, v_t = 1.0 + 0.5 * np.sin(t), 2.0, 2.0, 1e-3
    signals = {"x_enc": t + 0.5 * (1.0 - np.cos(t)), "F_m": np.ones(2001), "v_r": v}
    options = {**PLAIN, "mu": mu, "v_t": v_t, "w_q": k * mu * v_t}
    found = observe("momentum_observer", signals, **options)["fmu.a_hat"]
    expected = 1.0 - np.exp(-k * mu * (t + 0.5 * (1.0 - np.cos(t))))
    np.testing.assert_allclose(found[1:], expected[:-1], atol=5e-3)


def binary_axis(_t, h, x, u):
    """Move 4 kg without friction; with forces in steps of 2^-8 N no sum is rounded for seconds."""
    force = np.round(u["u"] * 256.0) / 256.0 if h else 0.0
    place, v = x[0] + h * x[1] + h * h / 8.0 * force, x[1] + h / 4.0 * force
    return np.array([place, v]), {"x_enc": place, "F_m": force}


@pytest.mark.parametrize(
    ("name", "mode"),
    [
        ("dob", {}),
        ("coulomb_observer", {}),
        ("momentum_observer", {"tau_f": 0.0}),
        ("momentum_observer", {"tau_f": 0.0, "coulomb": False}),
    ],
)
def test_without_a_disturbance_the_loop_stays_as_it_is(fmus, name, mode):
    """Bit for bit, where the axis is exactly that of the observer."""
    h, ports = 2.0**-11, models.load_model(name).ports
    values = {"T_s": h, "m": 4.0, "b": 0.0, "tau_i": 0.0, **mode}
    forces = []
    for observed in (False, True):
        system = cosim.System()
        system.add("controller", fmus / "velocity_controller.fmu", {"T_s": h})
        axis = cosim.Function(binary_axis, {"u": "N"}, {"x_enc": "m", "F_m": "N"}, np.zeros(2))
        system.add("axis", axis)
        system.add("observer", fmus / f"{name}.fmu", values)
        system.expose("v_cmd", "controller.v_cmd", *["observer.v_r"] * ("v_r" in ports.inputs))
        for source, *places in (
            ("controller.u", "axis.u"),
            ("axis.x_enc", "controller.x_enc", "observer.x_enc"),
            ("axis.F_m", "observer.F_m"),
            *[("observer.F", "controller.F_ff")] * observed,
        ):
            for place in places:
                system.connect(source, place)
        sine = cosim.SineSweep(frequency=(5.0, 5.0), amplitude=(0.04, 0.04), duration=1.0)
        result = system.prepare(step=h, stop=1.0, constant_step=True).run(inputs={"v_cmd": sine})
        forces.append(result["controller.u"])
    assert np.ptp(forces[0]) > 10.0
    assert forces[0].tobytes() == forces[1].tobytes()


P = {v.name: v.start for v in models.load_model("dob").variables if v.role == "parameter"}


def axis(force: float, n: int, change: float = 0.0) -> np.ndarray:
    """Return the position at n + 1 samples under a force alone, which changes at each sample."""
    rates = np.array([[0.0, 1.0, 0.0], [0.0, -P["b"] / P["m"], 1.0 / P["m"]], [0.0, 0.0, 0.0]])
    state, move, x = np.array([0.0, 0.0, force]), expm(rates * T), []
    for _ in range(n + 1):
        x.append(state[0])
        state = move @ state + [0.0, 0.0, change]
    return np.array(x)


def test_only_order_2_follows_a_ramp_without_an_error(observe):
    """Of order 1 the error is what one sample adds over what the correction takes away."""
    x, rate = axis(0.0, 800, 40.0 * T), 40.0
    weights = FilterSpecification(4e-7, 0.05, 1.5), FilterSpecification(4e-7, 0.05, 300.0, 2)
    designed = [design_velocity_filter(Axis(P["m"], P["b"], P["tau_i"]), T, w) for w in weights]
    lag, none = (
        rate * T * np.arange(-1, 800)
        - observe("dob", {"x_enc": x, "F_m": 0 * x}, **Observer(one).parameters())["fmu.d_hat"]
        for one in designed
    )
    first = designed[0]
    A = first.disturbance().A[:3, :3]
    expected = np.linalg.solve(np.eye(3) - A, [0.0, 0.0, rate * T])[2]
    assert lag[-1] == pytest.approx(expected, rel=1e-6)
    assert abs(none[-1]) < 1e-6 * expected
