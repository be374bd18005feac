"""Which exponent a curve has, and what is not motion in a position."""

from dataclasses import replace

import numpy as np
import pytest

from stickslip.identification.criteria.motion import position_noise
from stickslip.identification.criteria.unknowns import NAMES, Unknowns
from stickslip.identification.fitting.fit import fit
from stickslip.identification.fitting.multistart import (
    V_S,
    with_exponent,
    without_stribeck,
)

TRUTH = dict(zip(NAMES, [9.0, 6.0, 1e-3, 4e5, 4e3, 5.5, 6.6, 0.0, 1e-4], strict=True))


class Curve:
    """Sees friction at steady speeds, with noise."""

    name, used = "curve", slice(None)
    each = staticmethod(lambda function, items: [function(item) for item in items])

    def __init__(self, delta, speeds, **changes):
        self.v = speeds
        noise = np.random.default_rng(0).normal(0.0, 0.01, len(speeds))
        self.seen = self.friction({**TRUTH, "delta": delta, **changes}) + noise

    def friction(self, p):
        return p["F_c"] + (p["F_s"] - p["F_c"]) * np.exp(-((self.v / p["v_s"]) ** p["delta"]))

    def residual(self, values):
        return self.seen - self.friction(values)


def begun(judge):
    n = len(NAMES)
    middle = np.zeros(n)
    unknowns = Unknowns(100.0, 6.0, 5e-4, middle, np.full(n, 1e3), middle - 50.0, middle + 50.0)
    return fit(judge, unknowns, unknowns.coordinates(TRUTH))


@pytest.mark.parametrize("delta", [1.0, 2.0])
def test_a_curve_that_shows_tells_its_exponent(delta):
    judge = Curve(delta, np.linspace(1e-5, 4e-3, 400))
    found, ambiguity = with_exponent(judge, begun(judge))
    assert found.unknowns.delta == delta
    assert not ambiguity.any()
    for name in ("F_s", "F_c", "v_s"):
        assert found.parameters[name] == pytest.approx(TRUTH[name], rel=0.02)


@pytest.mark.parametrize("delta", [1.0, 2.0])
def test_what_is_not_sure_stays_the_papers_and_is_doubted(delta):
    judge = Curve(delta, np.linspace(1e-5, 4e-3, 400))
    first = begun(judge)
    found, ambiguity = with_exponent(judge, first, 0.0)
    assert found.unknowns.delta == 1.0
    other = fit(judge, replace(first.unknowns, delta=2.0), first.q)
    half_width = 1.96 * np.sqrt(ambiguity[V_S, V_S])
    assert 1.0 < half_width / abs(other.q[V_S] - first.q[V_S]) < 1.5


def test_a_rise_towards_rest_that_does_not_show_is_left_out():
    """F_s is sure there, as a level; only v_s tells that nothing falls."""
    judge = Curve(1.0, np.linspace(1e-5, 4e-3, 400), F_s=6.0)
    first = begun(judge)
    assert first.parameters["F_s"] != first.parameters["F_c"]
    found = without_stribeck(judge, first)
    assert found.parameters["F_s"] == pytest.approx(found.parameters["F_c"], rel=1e-6)
    assert found.parameters["F_c"] == pytest.approx(6.0, rel=1e-3)


def test_a_rise_towards_rest_that_shows_stays():
    judge = Curve(1.0, np.linspace(1e-5, 4e-3, 400))
    first = begun(judge)
    assert without_stribeck(judge, first) is first


def test_noise_is_told_from_motion():
    t = 5e-4 * np.arange(40_000)
    motion, noise = 0.02 * np.sin(3.0 * t), np.random.default_rng(1).normal(0.0, 2e-7, len(t))
    assert position_noise(motion + noise, 0.0) == pytest.approx(2e-7, rel=0.03)
    assert position_noise(motion, 4e-7) == pytest.approx(4e-7 / np.sqrt(12.0), rel=1e-6)
