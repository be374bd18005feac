"""The LuGre network: the feedforward while it does not learn, and the fixed point of learning."""

from __future__ import annotations

import numpy as np

from stickslip import cosim

T = 5e-4  # s
THETA = ("F_c", "sigma_0", "sigma_1", "F_s", "v_s")


def run(fmus, name, signals, record=None, **parameters):
    system = cosim.System()
    system.add("fmu", fmus / f"{name}.fmu", parameters)
    for signal in signals:
        system.expose(signal, f"fmu.{signal}")
    stop = T * (len(signals[next(iter(signals))]) - 1)
    with system.prepare(step=T, stop=stop, constant_step=True, record=record) as simulation:
        return simulation.run(inputs=signals)


def reference() -> np.ndarray:
    t = np.arange(4000) * T
    return 0.02 * np.sin(9 * t) * np.cos(2 * t) + 1e-4


def test_without_learning_it_is_the_feedforward_bit_for_bit(fmus):
    v, lugre = reference(), {"F_c": 4.0, "sigma_0": 3e5, "delta": 2.0, "lead": 2e-4}
    found = run(fmus, "lugre_network", {"v_r": v, "u": 50.0 * v}, gamma=0.0, **lugre)["fmu.F"]
    expected = run(fmus, "compensator", {"v": v}, hold=False, **lugre)["fmu.F_mean"]
    assert np.ptp(found) > 8.0
    assert found.tobytes() == expected.tobytes()


def test_from_a_perfect_answer_it_learns_the_parameters(fmus):
    """The controller adds what the exact force lacks, at once: all but F_s and v_s are found.

    The command is the exact force, so that u less the network's own force is what it lacks.
    """
    v = np.tile(reference(), 5)
    lugre = {"m": 1e-6, "b": 0.0}
    exact = run(fmus, "compensator", {"v": v}, hold=False, lead=1e-4)["fmu.F_mean"]
    names = [f"fmu.theta[{i}]" for i in range(1, 6)]
    half = {"F_c": 3.0, "F_s": 4.5, "sigma_0": 2e5, "sigma_1": 2200.0}
    options = {"gamma": 0.02, "D": 0, **half, **lugre}
    # The command of a period comes with the sample at its end, when D = 0 pairs it with the next.
    found = run(fmus, "lugre_network", {"v_r": v, "u": exact}, tuple(names), **options)
    F_c, sigma_0, sigma_1, F_s, _ = (found[name][-1] for name in names)
    assert abs(F_c / 5.999 - 1.0) < 0.02
    assert abs(sigma_0 / 3.9162e5 - 1.0) < 0.15
    assert abs(sigma_1 / 4424.8 - 1.0) < 0.15
    assert F_s > F_c
