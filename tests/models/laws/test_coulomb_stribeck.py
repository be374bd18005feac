"""Static friction with events: closed forms of stopping, true rest, and break-away."""

import numpy as np
import pytest

H = 5e-4  # s
M, B, F_C = 5.557, 6.6135, 5.999


def test_a_mass_that_coasts_stops_where_and_when_the_closed_form_says(push):
    v0 = 0.57685
    found = push("coulomb_stribeck", H, np.zeros(1200), F_s=F_C, v=v0)
    time = M / B * np.log1p(B * v0 / F_C)
    distance = M / B * (v0 - F_C / B * np.log1p(B * v0 / F_C))
    assert found["x"][-1] == pytest.approx(distance, abs=1e-9)
    standing = np.flatnonzero(found["v"] == 0.0)[0]
    assert (standing - 1) * H < time <= standing * H
    assert len(set(found["x"][standing:])) == 1


@pytest.mark.parametrize("u", [8.99, -8.99])
def test_below_static_friction_it_stands_for_ever_and_friction_is_the_reaction(push, u):
    found = push("coulomb_stribeck", H, np.full(2000, u))
    assert not found["x"].any()
    assert not found["v"].any()
    np.testing.assert_array_equal(found["F_f"][1:], u)
