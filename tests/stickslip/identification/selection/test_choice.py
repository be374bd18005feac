"""The choice of a law, and a law that leaves more force than noise explains."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from stickslip.catalog.parameters import friction_law
from stickslip.identification.selection.choice import Cause, along_the_travel, choose, mismatch
from stickslip.identification.selection.folds import Moving
from stickslip.identification.selection.prediction import Candidate, Prediction


def predicted(law, error, *, explained=0.1, is_level=False, shown=("F_s",), seed=0, fails=False):
    """Return a prediction whose error varies from block to block."""
    rng = np.random.default_rng(seed)
    squares = error**2 * np.exp(0.2 * rng.standard_normal(40))
    squares *= error**2 / squares.mean()
    candidate = Candidate(friction_law(law), is_level=is_level)
    shown = () if is_level else shown
    moving = Moving(error, 0.5 * error, fails)
    return Prediction(candidate, {}, {}, error, error / 6.0, explained, squares, shown, moving)


def laws(plain=2.0, lugre=1.0, static=2.0, gms=1.0):
    return [
        predicted("coulomb_stribeck", plain, is_level=True, seed=1),
        predicted("lugre", lugre, seed=2),
        predicted("coulomb_stribeck", static, seed=3),
        predicted("gms", gms, seed=4),
    ]


def hidden(error):
    """Return predictions of laws whose parameters do not show."""
    return [replace(one, shown=()) for one in laws(2.0, error, 2.0, 2.0)]


CHOICES = {
    "LuGre wins a tie": (laws(gms=0.99), "lugre", "GMS tie"),
    "a law that predicts better wins": (laws(gms=0.8), "gms", ""),
    "no law is better": (laws(2.0, 2.0, 1.99, 2.01), "level", "nothing more can be seen"),
    "what does not show is not much better": (hidden(1.6), "level", ""),
    "what does not show is much better": (hidden(1.2), "lugre", ""),
}


@pytest.mark.parametrize("name", CHOICES)
def test_the_law_that_predicts_best_is_chosen(name):
    found, law, reason = CHOICES[name]
    choice = choose(found)
    chosen = choice.chosen.candidate
    assert ("level" if chosen.is_level else chosen.law.name) == law
    assert reason in choice.reason


def test_a_law_that_fails_beside_a_regression_is_not_chosen():
    found = laws(lugre=0.5)
    found[1] = predicted("lugre", 0.5, seed=2, fails=True)
    assert choose(found).chosen.candidate.law.name == "gms"
    found[3] = predicted("gms", 0.5, seed=4, fails=True)
    assert choose(found).chosen.candidate.is_level


def test_a_law_that_is_much_worse_in_one_block_only_is_not_tied_and_one_that_fails_is_worse():
    """As where the drive breaks away once, and a law without presliding gives any force at rest."""
    found = laws(plain=4.0, lugre=0.5, static=4.0, gms=9.0)
    found[0] = replace(found[0], squares=np.where(np.arange(40) == 7, 40 * 16.0, 1e-9))
    assert choose(found).chosen.candidate.law.name == "lugre"
    # one that fails there is worse
    found = laws(lugre=0.5, gms=0.5)
    squares = 1.3 * found[3].squares
    squares[7] = 40.0
    failing = replace(found[1], squares=squares, force=float(np.sqrt(squares.mean())))
    assert choose([found[0], failing, *found[2:]]).chosen.candidate.law.name == "gms"


T_S = 1e-3


def test_a_law_that_fails_beside_a_regression_has_wrong_values():
    """Unless its error is that of noise, of which a regression with less mass leaves less."""
    failing = predicted("lugre", 0.12, explained=0.05, fails=True)
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
    law = predicted("lugre", 0.5)
    (finding,) = mismatch(law, [predicted("gms", 0.12)], [delay], rotary=True)
    assert "another law, GMS, leaves 0.12 N m, a delay of 3 ms leaves 0.45 N m" in finding.figure
    assert finding.advice == 'give law="gms"'
    (finding,) = mismatch(law, (), [delay], rotary=False)
    assert finding.advice == "take the values as coarse"
    likely = replace(delay, left=0.2)
    (finding,) = mismatch(law, [predicted("gms", 0.4)], [likely], rotary=False)
    assert finding.advice == "shift the force"
    (finding,) = mismatch(law, [predicted("gms", 0.495)], (), rotary=False)
    assert "GMS" not in finding.figure  # it is tied


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
