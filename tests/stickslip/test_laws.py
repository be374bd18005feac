"""A friction law by itself from Python, against closed forms."""

import numpy as np
import pytest

import stickslip as ss

F_C, SIGMA_0 = 5.999, 3.9162e5  # N, N/m: start values of every law


def test_dahl_under_a_displacement_is_its_closed_form():
    result = ss.run_law("dahl", position=ss.Table([0.0, 1.0], [0.0, 2e-5]), stop=1.0, step=1e-2)
    expected = F_C * (1.0 - np.exp(-SIGMA_0 * 2e-5 * result.time / F_C))
    np.testing.assert_allclose(result["F_f"], expected, rtol=1e-12, atol=1e-12)
    same = ss.run_law("dahl", velocity=2e-5, stop=1.0, step=1e-2)
    np.testing.assert_allclose(same["dahl.F_f"], expected, rtol=1e-12, atol=1e-12)


def test_a_mass_slides_under_a_force_as_its_closed_form():
    parameters = {"F_c": 3.0, "F_s": 3.0, "m": 2.0, "b": 4.0}
    result = ss.run_law("coulomb_stribeck", force=11.0, stop=0.7, parameters=parameters)
    expected = 8.0 / 4.0 * (1.0 - np.exp(-2.0 * result.time))
    np.testing.assert_allclose(result["v"], expected, rtol=1e-6, atol=2e-8)


def test_the_stop_is_rounded_up_to_whole_steps():
    assert ss.run_law("gms", velocity=1e-3, stop=0.1005, step=1e-3).time[-1] == pytest.approx(0.101)
    assert ss.run_law("gms", velocity=1e-3, stop=0.3, step=1e-1).time[-1] == pytest.approx(0.3)


def test_one_of_motion_and_force_is_given():
    for given in ({}, {"velocity": 1e-3, "force": 1.0}):
        with pytest.raises(ss.Fault, match="expected one of velocity, position and force"):
            ss.run_law("lugre", stop=1.0, **given)
    with pytest.raises(ss.Fault, match="no friction law 'viscous'"):
        ss.run_law("viscous", velocity=1e-3, stop=1.0)
