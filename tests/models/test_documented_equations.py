"""Compensators with shares other than 1, and each of their modes, against their equations."""

import numpy as np
import pytest

from stickslip import models
from tests.models import make_references as references

SHARES = (0.0, 0.3, 0.5, 1.0)
CASCADE, PID = {"K_x": 60.0}, {"P_x": 3e5, "I_x": 4e6, "K_i": 0.0}
CONTROLLERS = [
    *({"tau_f": 0.0}, {"m_ff": 5.5, "velocity_feedforward": 0.5}, {"u_max": 20.0, "K_i": 1e6}),
    *({"use_v_hat": 1.0}, CASCADE),
    *({**CASCADE, "use_v_hat": 1.0, "K_i": 1e6, "u_max": 50.0}, PID, {**PID, "u_max": 20.0}),
    {**PID, "use_v_hat": 1.0, "I_x": 4e8, "u_max": 30.0},
    {"K_p": 0.0, "K_i": 0.0, "P_x": 2e5},
]
CASES = [
    ("velocity_filter", {"b": 0.0}),
    ("velocity_filter", {"m": 0.5, "b": 900.0, "tau_i": 2e-3}),
    ("velocity_filter", {"m": 12.0, "tau_i": 0.0}),
    *(("dob", {"share": share, "L_1": 1e7}) for share in SHARES),
    *(("coulomb_observer", {"share": share, "k_a": 0.2, "a_0": 3.0}) for share in SHARES),
    *(("coulomb_observer", {"share": share, "measured": 1.0}) for share in SHARES),
    *(("momentum_observer", {"share": share, "mu": 1.4, "a_0": 3.0}) for share in SHARES),
    *(("momentum_observer", {"share": share, "coulomb": 0.0}) for share in SHARES),
    *(("momentum_observer", {"share": share, "measured": 1.0}) for share in SHARES),
    *((name, {"F_0": 9.0}) for name in ("dob", "coulomb_observer", "momentum_observer")),
    *((name, {"F_0": -9.0}) for name in ("velocity_filter", "adaptive_scale")),
    ("dob", {"onset": 5e-6}),
    ("coulomb_observer", {"onset": 1e-5, "a_0": 3.0, "k_a": 0.2}),
    ("momentum_observer", {"onset": 1e-5, "a_0": 3.0}),
    *(("adaptive_scale", {"s_0": s_0, "rate": 20.0, "q_min": 1e-5}) for s_0 in (0.5, 1.3)),
    *(("adaptive_scale", {"rate": 20.0} | least) for least in ({"q_min": 8e-4}, {"v_min": 0.04})),
    ("adaptive_scale", {"s_0": 40.0, "rate": 200.0, "q_min": 1e-5, "least": 0.99, "most": 1.01}),
    *(("static_feedforward", {"asymmetry": share, "b": 7.0}) for share in (-0.5, 0.3)),
    ("static_feedforward", {"v_t": 1e-12, "lead": 4e-3}),
    ("position_force", {"F_0": 30.0, "g_s": -2.0, "g_c": 4.0, "cogging_s[1]": 0.0}),
    ("position_force", {"pitch": 0.003, "cogging_c[1]": 0.7, "cogging_s[2]": 3.0}),
    ("position_force", {"g_s": 3.0, "g_c": 2.0, "mu_g": 0.2, "F_c": 1.5}),
    ("position_force", {"pitch": 3e-7, "cogging_s[3]": -1.5, "cogging_c[3]": 2.0}),
    *(("velocity_controller", change) for change in CONTROLLERS),
    ("nominal_loop", {"D": 2.0}),
    ("lffc", {"gamma": 0.3, "D": 3.0, "F_max": 4.0, "w_0[1,5]": 3.0, "w_0[2,1]": -3.0}),
    ("rbf", {"gamma": 0.3, "D": 3.0, "F_max": 4.0, "w_0[6,4]": 3.0}),
    ("mlp", {"gamma": 0.3, "D": 3.0, "F_max": 1.0, "w_0[3,4]": 0.5}),
    ("mlp", {"gamma": 1.0, "D": 0.0, "F_max": 0.1, "w_0[3,4]": 0.5}),
    ("lugre_network", {"gamma": 0.03, "D": 3.0}),
    ("lugre_network", {"gamma": 0.0, "delta": 2.0, "lead": 2e-4, "F_c": 4.0}),
    ("lugre_network", {"gamma": 0.3, "F_c": 1.0, "F_s": 1.01, "D": 0.0}),
    *(("lugre", change) for change in ({"delta": 2.0}, {"hold": 0.0}, {"lead": 2e-3, "b": 30.0})),
    ("lugre", {"v_d": 2e-3, "hold": 0.0, "lead": 1e-4}),
    ("elasto_plastic", {"z_ba": 0.3, "delta": 2.0}),
    *(("elasto_plastic", {"z_ba": z_ba}) for z_ba in (0.0, 0.05, 0.7, 0.95)),
    *(("elasto_plastic", {"sigma_0": sigma_0, "sigma_1": 0.0}) for sigma_0 in (4e3, 4e7)),
    ("gms", {"alpha[1]": 0.7, "alpha[4]": 0.1, "kappa[2]": 0.6, "C": 300.0}),
    ("leuven", {"W[1]": 0.5, "kappa[4]": 0.6, "delta": 2.0}),
    *(("armstrong", {"gamma": gamma}) for gamma in (0.0, 1e-3, 0.5, 1e5)),
]
GUIDE = {"asymmetric": 1.0, "asymmetry": 0.3, "mu": 0.01, "load": -80.0, "mu_g": 0.2}
GUIDE |= {"position_dependent": 1.0, "position_amplitude": 0.3, "position_period": 1e-3}
GUIDE |= {"drift": 0.3, "drift_time": 0.05, "sde": 1e-5, "sde_period": 2e-4, "F_0": 0.5}
GUIDE |= {"ripple": 1.0, "ripple_amplitude": 3.0, "ripple_period": 2e-3, "pitch": 3e-3}
GUIDE |= {"g_s": 8.0, "g_c": -3.0, "cogging_s[2]": 0.7, "cogging_c[1]": -1.1}
"""All that varies along the guide of a drive, with time and with the load; any of them moves the
drive by 150 nm or more."""
NEAR = {"x": 2e-8, "x_enc": 2e-8, "v": 5e-6, "F_f": 2e-2}  # what varies is held in each sub-step
LUGRE = {"k_e": 0.6, "tau_f": 0.0, "delta": 2.0}
HELD = ((0.02, 0.018), (2e-4, -1e-4), (-0.001, 0.003), (0.0, 0.01))  # measured, expected [m/s]


IDEAL = dict.fromkeys(("current_loop", "dac", "encoder"), 0.0)
EVERY = [
    *((name, changes, {}, {}) for name, changes in CASES),
    # the damping of the LuGre observer has its share, also where the velocity reverses
    *(
        ("lugre_observer", {**LUGRE, "share_1": share, **more}, {}, {"n": 41, "held": held})
        for share, held, more in (
            *((share, held, {}) for share, held in zip(SHARES, HELD, strict=True)),
            *((0.3, HELD[0], more) for more in ({"reference": 1.0}, {"v_d": 5e-3})),
        )
    ),
    *(
        pytest.param(
            "lugre_observer", {**LUGRE, "share_1": 0.3, **more}, {}, {"n": 251},
            marks=pytest.mark.thorough,
        )
        for more in ({}, {"v_d": 5e-3}, {"reference": 1.0})
    ),
    ("drive", IDEAL | GUIDE, NEAR, {"n": 101}),
    ("stage", {"v_d": 2e-3}, {"F_f": 1e-4}, {}),
]  # fmt: skip
"""Model or law, what differs from its start values, distances allowed, and the signals."""


@pytest.mark.parametrize(("name", "changes", "near", "signals"), EVERY, ids=str)
def test_the_outputs_are_those_of_the_equations(with_law, observe, name, changes, near, signals):
    """As make_references.py solves them."""
    own = getattr(references, name)
    expected = own(references.start_values(name) | changes, **signals)
    law = name in models.law_names()
    known = {v.name: v for v in references.model_of(name).variables}
    values = {n: bool(v) if known[n].type == "boolean" else v for n, v in changes.items()}
    inputs = {n: np.asarray(v) for n, v in expected.items() if known[n].role == "input"}
    path = with_law("compensator", name) if law else name
    found = observe(path, inputs, **values)
    outputs = expected.keys() - inputs - {"time"}
    for output in outputs:
        off = near.get(output, 1e-7)
        np.testing.assert_allclose(
            found[f"fmu.{output}"], expected[output], rtol=1e-7, atol=off, err_msg=output
        )
    assert max(np.ptp(expected[output]) for output in outputs) > 0.02


def test_a_weight_of_the_network_stays_within_its_limit(observe):
    record = tuple(f"fmu.w[{i},{j}]" for i in range(1, 9) for j in range(1, 5))
    signals = {"v_r": np.full(600, 0.05), "u": np.full(600, 1e4)}
    found = observe("mlp", signals, record, gamma=1.0, D=0, m=1e-6, b=0.0)
    largest = [max(np.abs(found[name]).max() for name in record[j::4]) for j in range(4)]
    assert max(largest[:3]) == 20.0
    assert largest[3] == 1.0
