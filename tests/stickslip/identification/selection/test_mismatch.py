"""A law that leaves more force than noise explains, and the causes that are tested."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from synthetic_predictions import predicted

from stickslip.identification.selection.choice import Cause, along_the_travel, mismatch

T_S = 1e-3


def found(error, explained):
    return replace(predicted("lugre", error), relative=error / 6.0, explained=explained)


def test_a_law_that_fails_beside_a_regression_has_wrong_values():
    """Unless its error is that of noise, of which a regression with less mass leaves less."""
    failing = replace(predicted("lugre", 0.12, fails=True), explained=0.05)
    finding, *_ = mismatch(failing, (), (), rotary=False)
    assert not list(mismatch(replace(failing, explained=0.1), (), (), rotary=False))
    assert finding.spoils == "values"
    assert finding.advice == 'give law="auto"'
    assert "0.12 N" in finding.figure
    assert "0.06 N" in finding.figure
    others = [predicted("gms", 0.02), predicted("dahl", 0.3)]
    for rivals, advice in ((others, 'give law="gms"'), (others[1:], "none of the laws compared")):
        first, *_ = mismatch(failing, rivals, (), rotary=False)
        assert first.advice.startswith(advice)
    plain = predicted("coulomb_stribeck", 0.12, is_level=True, fails=True)
    assert not list(mismatch(plain, (), (), rotary=False))


def test_causes_are_listed_with_their_figures_and_the_likely_one_is_advised():
    delay = Cause("a delay of 3 ms", 0.45, "shift the force")
    law = found(0.5, 0.1)
    (finding,) = mismatch(law, [predicted("gms", 0.12)], [delay], rotary=True)
    assert "another law, GMS, leaves 0.12 N m, a delay of 3 ms leaves 0.45 N m" in finding.figure
    assert finding.advice == 'give law="gms"'
    (finding,) = mismatch(law, (), [delay], rotary=False)
    assert finding.advice == "take the values as coarse"
    likely = replace(delay, left=0.2)
    (finding,) = mismatch(law, [predicted("gms", 0.4)], [likely], rotary=False)
    assert finding.advice == "shift the force"


def test_a_law_that_is_tied_is_no_cause():
    (finding,) = mismatch(found(0.5, 0.1), [predicted("gms", 0.495)], (), rotary=False)
    assert "GMS" not in finding.figure


@pytest.mark.parametrize("amplitude", [0.0, 0.3])
@pytest.mark.parametrize("turns", [False, True])
def test_force_along_the_travel(amplitude, turns):
    """Ripple has one sign at a position, friction that of the motion."""
    rng = np.random.default_rng(0)
    t = np.arange(0.0, 20.0, T_S)
    x = 0.05 * np.sin(2.0 * np.pi * 0.31 * t)
    v = np.gradient(x, T_S)
    wave = amplitude * np.sin(2.0 * np.pi * x / 0.02) * (np.sign(v) if turns else 1.0)
    residual = wave + 0.1 * rng.standard_normal(len(t))
    motion = SimpleNamespace(v=v)
    inverse = SimpleNamespace(position=x, used=slice(None), motion=motion, cutoff=60.0, T_s=T_S)
    cause = along_the_travel(inverse, residual)
    assert cause.left == pytest.approx(0.1, rel=0.15)
