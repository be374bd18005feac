"""Compensators with shares other than 1, and each of their modes, against their equations."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest

from stickslip import cosim, models

STEP = 5e-4  # s
SCRIPT = runpy.run_path(str(Path(__file__).with_name("make_references.py")))
SHARES = (0.0, 0.3, 0.5, 1.0)
CASES = [
    *(("dob", {"share": share, "L_1": 1e7}) for share in SHARES),
    *(("coulomb_observer", {"share": share, "k_a": 0.2, "a_0": 3.0}) for share in SHARES),
    *(("coulomb_observer", {"share": share, "measured": 1.0}) for share in SHARES),
    *(("momentum_observer", {"share": share, "mu": 1.4, "a_0": 3.0}) for share in SHARES),
    *(("momentum_observer", {"share": share, "coulomb": 0.0}) for share in SHARES),
    *(("momentum_observer", {"share": share, "measured": 1.0}) for share in SHARES),
    *(("adaptive_scale", {"s_0": s_0, "rate": 20.0, "q_min": 1e-5}) for s_0 in (0.5, 1.3)),
    *(("static_feedforward", {"asymmetry": share, "b": 7.0}) for share in (-0.5, 0.3)),
    ("lffc", {"gamma": 0.3, "D": 3.0}),
    ("rbf", {"gamma": 0.3, "D": 3.0}),
    ("mlp", {"gamma": 0.3, "D": 3.0}),
    ("lugre_network", {"gamma": 0.03, "D": 3.0}),
    ("lugre", {"delta": 2.0}),
    ("elasto_plastic", {"z_ba": 0.3, "delta": 2.0}),
    ("gms", {"alpha[1]": 0.7, "alpha[4]": 0.1, "kappa[2]": 0.6, "C": 300.0}),
    ("leuven", {"W[1]": 0.5, "kappa[4]": 0.6, "delta": 2.0}),
    ("armstrong", {"gamma": 0.5}),
]
LUGRE = {"k_e": 0.6, "tau_f": 0.0, "delta": 2.0}
HELD = ((0.02, 0.018), (2e-4, -1e-4), (-0.001, 0.003))  # measured and expected velocity [m/s]


@pytest.mark.parametrize(("name", "changes"), CASES, ids=str)
def test_the_force_is_that_of_the_equations(with_law, tmp_path, name, changes):
    compare(with_law, tmp_path, name, changes)


@pytest.mark.parametrize("held", HELD, ids=str)
@pytest.mark.parametrize("share_1", SHARES)
def test_the_damping_of_the_lugre_observer_has_its_share(with_law, tmp_path, share_1, held):
    values = {**LUGRE, "share_1": share_1}
    compare(with_law, tmp_path, "lugre_observer", values, n=61, held=held)


THOROUGH = [pytest.param(more, marks=pytest.mark.thorough) for more in ({}, {"v_d": 5e-3})]


@pytest.mark.parametrize("more", [{"reference": 1.0}, *THOROUGH], ids=str)
def test_it_has_it_where_the_velocity_reverses(with_law, tmp_path, more):
    values = {**LUGRE, "share_1": 0.3, **more}
    compare(with_law, tmp_path, "lugre_observer", values, n=251)


def compare(with_law, folder, name, changes, **signals):
    """Compare the FMU with the equations, as make_references.py solves them."""
    expected = SCRIPT[name](SCRIPT["start_values"](name) | changes, **signals)
    law = name in models.law_names()
    path = with_law("compensator", name) if law else models.build_fmu(name, folder)
    system = cosim.System()
    system.add("fmu", path)
    known = system.components["fmu"].variables
    switches = {n: bool(v) if known[n].type == "Boolean" else v for n, v in changes.items()}
    for one, value in switches.items():
        system.set(f"fmu.{one}", value)
    inputs = {
        n: np.asarray(v)
        for n, v in expected.items()
        if n in known and known[n].causality == "input"
    }
    for signal in inputs:
        system.expose(signal, f"fmu.{signal}")
    with system.prepare(step=STEP, stop=STEP * (len(expected["time"]) - 1)) as simulation:
        found = simulation.run(inputs=inputs)
    force = "F_mean" if law else "F"
    assert np.ptp(expected[force]) > 1.0
    np.testing.assert_allclose(found[f"fmu.{force}"], expected[force], rtol=1e-7, atol=1e-7)
