"""Which exponent a curve has, and what is not motion in a position."""

from dataclasses import replace

import numpy as np
import pytest

from stickslip.catalog.parameters import ParameterSpace, friction_law
from stickslip.identification.criteria.motion import encoder_noise, position_noise
from stickslip.identification.criteria.runs import Criterion
from stickslip.identification.fitting.fit import fit
from stickslip.identification.fitting.search import select, variants, without_stribeck

TRUTH = {
    "F_s": 9.0, "F_c": 6.0, "v_s": 1e-3, "sigma_0": 4e5, "sigma_1": 4e3,
    "m": 5.5, "b": 6.6, "F_0": 0.0, "delay": 1e-4,
}  # fmt: skip


class Curve(Criterion):
    """Measures friction at steady speeds, with noise."""

    every = 1

    def __init__(self, delta, speeds, **changes):
        self.v, self.space = speeds, space()
        noise = np.random.default_rng(0).normal(0.0, 0.01, len(speeds))
        self.seen = self.friction({**TRUTH, "delta": delta, **changes}) + noise

    def friction(self, p):
        return p["F_c"] + (p["F_s"] - p["F_c"]) * np.exp(-((self.v / p["v_s"]) ** p["delta"]))

    def residual(self, values):
        return self.seen - self.friction(values)


def space():
    free = ParameterSpace.of(friction_law())
    wide = np.full(len(free.names), 50.0)
    units = np.array([100.0 if n == "b" else 6.0 if n == "F_0" else 5e-4 for n in free.names])
    return replace(
        free, units=units, prior_deviation=np.full(len(wide), 1e3), lower=-wide, upper=wide
    )


def begun(criterion):
    return fit(criterion, [criterion.space.encode(TRUTH)])


@pytest.mark.parametrize("delta", [1.0, 2.0])
def test_a_curve_that_shows_tells_its_exponent(delta):
    criterion = Curve(delta, np.linspace(1e-5, 4e-3, 400))
    selection = select(variants(criterion, begun(criterion)))
    assert selection.fit.space.constants["delta"] == delta
    assert not selection.ambiguity.any()
    for name in ("F_s", "F_c", "v_s"):
        assert selection.fit.parameters[name] == pytest.approx(TRUTH[name], rel=0.02)
    # what is not sure stays the paper's, and is doubted
    first = begun(criterion)
    selection = select(variants(criterion, first), sure=0.0)
    assert selection.fit.space.constants["delta"] == 1.0
    other = fit(criterion.over(first.space.fixed(delta=2.0)), [first.q])
    v_s = first.space.index("v_s")
    half_width = 1.96 * np.sqrt(selection.ambiguity[v_s, v_s])
    assert 1.0 < half_width / abs(other.q[v_s] - first.q[v_s]) < 1.5


def test_a_rise_towards_rest_is_left_out_where_it_does_not_show():
    """F_s is sure there, as a level; only v_s tells that nothing falls."""
    criterion = Curve(1.0, np.linspace(1e-5, 4e-3, 400), F_s=6.0)
    first = begun(criterion)
    assert first.parameters["F_s"] != first.parameters["F_c"]
    found = without_stribeck(criterion, first)
    assert found.parameters["F_s"] == pytest.approx(found.parameters["F_c"], rel=1e-6)
    assert found.parameters["F_c"] == pytest.approx(6.0, rel=1e-3)
    criterion = Curve(1.0, np.linspace(1e-5, 4e-3, 400))
    first = begun(criterion)
    assert without_stribeck(criterion, first) is first


def test_noise_is_told_from_motion():
    t = 5e-4 * np.arange(40_000)
    motion, noise = 0.02 * np.sin(3.0 * t), np.random.default_rng(1).normal(0.0, 2e-7, len(t))
    assert position_noise(motion + noise, 0.0) == pytest.approx(2e-7, rel=0.03)
    assert position_noise(motion, 4e-7) == pytest.approx(4e-7 / np.sqrt(12.0), rel=1e-6)


@pytest.mark.parametrize("step", [0.0, 4e-7])
@pytest.mark.parametrize("rate", [2000.0, 100.0])
def test_noise_of_an_encoder_is_told_from_its_steps(rate, step):
    """Also from motion at few samples per second, and from jumps of the acceleration."""
    t = np.arange(40_000) / rate
    motion = 0.02 * np.abs(np.sin(3.0 * t))
    for noise in (0.0, 3e-7):
        shown = motion + np.random.default_rng(1).normal(0.0, noise, len(t))
        shown = step * np.round(shown / step) if step else shown
        assert encoder_noise(shown, step) == pytest.approx(noise, rel=0.1, abs=0.2 * step + 1e-8)
    assert encoder_noise(np.zeros(len(t)), step) == 0.0
