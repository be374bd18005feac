import numpy as np
import pytest

from stickslip.identification.criteria.unknowns import NAMES, Unknowns

VALUES = dict(
    zip(NAMES, [9.0, 6.0, 5e-4, 4e5, 4e3, 5.5, 6.6, -0.3, 1e-4], strict=True)
)  # fmt: skip


@pytest.fixture
def unknowns():
    n = len(NAMES)
    return Unknowns(
        100.0, 6.0, 5e-4, np.zeros(n), np.full(n, np.inf), np.full(n, -50.0), np.full(n, 50.0)
    )


def test_values_and_coordinates_are_each_others_inverse(unknowns):
    back = unknowns.values(unknowns.coordinates(VALUES))
    assert back == pytest.approx({**VALUES, "delta": 1.0}, rel=1e-12)


def test_slopes_are_the_derivatives(unknowns):
    q = unknowns.coordinates(VALUES)
    for index in range(len(q)):
        step = np.zeros(len(q))
        step[index] = 1e-6
        high, low = unknowns.values(q + step), unknowns.values(q - step)
        slope = np.array([(high[name] - low[name]) / 2e-6 for name in NAMES])
        np.testing.assert_allclose(unknowns.slopes(q)[:, index], slope, rtol=1e-6, atol=1e-6)


def test_the_stick_force_cannot_fall_below_the_coulomb_force(unknowns):
    q = unknowns.coordinates({**VALUES, "F_s": 3.0})
    bounded = np.maximum(q, np.where(np.arange(len(q)) == 0, 0.0, -np.inf))
    values = unknowns.values(bounded)
    assert values["F_s"] >= values["F_c"]
