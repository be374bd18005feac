"""A value that is not identifiable is taken where it cannot hurt, and none beyond the log."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from stickslip.catalog.parameters import ParameterSpace, friction_law
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.runs import candidate_fmus
from stickslip.identification.fitting.identifiability import (
    IDENTIFIABLE,
    LEVELS,
    NOT_IDENTIFIABLE,
    WEAKLY_IDENTIFIABLE,
    Identifiability,
    bounded_by,
    conservative,
    largest_friction,
)
from stickslip.logs import Recording

LUGRE = {"F_s": 9.0, "F_c": 6.0, "v_s": 5e-4, "sigma_0": 4e5, "sigma_1": 4e3, "m": 5.0, "b": 6.0}


def known(changes=None, **levels):
    """Every value with an interval from a tenth of it to ten times it."""
    return {
        name: Identifiability(
            value, 0.1 * value, 0.1 * value, 10.0 * value, *2 * (levels.get(name, IDENTIFIABLE),)
        )
        for name, value in {**LUGRE, **(changes or {})}.items()
    }


def taken(known, largest=np.inf, law="lugre"):
    found = conservative(known, ParameterSpace.of(friction_law(law)), largest)
    assert found.keys() == known.keys()
    for name, one in found.items():
        moved = one.value != known[name].value
        assert (f"{name} = " in one.sentence and "is used" in one.sentence) == moved
    return {name: one.value for name, one in found.items()}


def test_what_is_identifiable_stays_and_what_is_not_is_taken_at_its_weak_end():
    assert taken(known(), 9.0) == LUGRE
    assert taken(known(m=NOT_IDENTIFIABLE, b=NOT_IDENTIFIABLE), 9.0) == LUGRE
    assert taken(known(F_s=NOT_IDENTIFIABLE)) == {**LUGRE, "F_s": 6.0}
    assert taken(known(sigma_1=NOT_IDENTIFIABLE)) == {**LUGRE, "sigma_1": 2000.0}
    assert taken(known(v_s=NOT_IDENTIFIABLE))["v_s"] == pytest.approx(5e-5)
    assert taken(known(sigma_0=NOT_IDENTIFIABLE)) == {**LUGRE, "sigma_0": 2e5}
    assert taken(known(sigma_0=WEAKLY_IDENTIFIABLE)) == {**LUGRE, "sigma_0": 2e5}
    assert taken(known(v_s=WEAKLY_IDENTIFIABLE))["v_s"] == pytest.approx(5e-5)
    both = taken(known(F_s=NOT_IDENTIFIABLE, F_c=NOT_IDENTIFIABLE))
    assert both["F_s"] == both["F_c"] == pytest.approx(0.6)
    gms = known({"C": 1500.0}, C=NOT_IDENTIFIABLE)
    assert taken(gms, law="gms")["C"] == 15000.0
    ratio = known({"z_ba": 0.7}, z_ba=NOT_IDENTIFIABLE)
    assert taken(ratio, law="elasto_plastic")["z_ba"] == 0.7


@pytest.mark.parametrize("level", LEVELS)
def test_no_static_friction_is_above_the_largest_in_the_log(level):
    """F_s = 120 N was fitted where the log never shows 9 N, unless it is identifiable."""
    found = taken(known({"F_s": 120.0}, F_s=level), 9.0)
    assert found["F_s"] == {NOT_IDENTIFIABLE: 6.0, WEAKLY_IDENTIFIABLE: 9.0}.get(level, 120.0)
    assert taken(known({"F_s": 120.0}, F_s=WEAKLY_IDENTIFIABLE), 5.0)["F_s"] == 6.0
    far = known({"F_s": 120.0}, F_s=level)
    far["F_s"] = replace(far["F_s"], low=100.0)
    low = conservative(far, ParameterSpace.of(friction_law()), 9.0)["F_s"].low
    assert low == {NOT_IDENTIFIABLE: 6.0, WEAKLY_IDENTIFIABLE: 7.2}.get(level, 100.0)
    space = ParameterSpace.of(friction_law())
    assert bounded_by({**LUGRE, "F_s": 120.0}, space, 9.0) == LUGRE


def test_the_largest_friction_is_the_measured_or_the_predicted_one_at_creep():
    """The measured one has noise; at high speed the mass would count."""
    n = 4000
    v = 0.04 * np.sin(np.linspace(0.0, 60.0, n))
    slow = np.abs(v) <= 0.1 * np.quantile(np.abs(v), 0.99)
    model = np.where(slow, 8.0, 6.0) * np.sign(v)

    def inverse(rest):
        return SimpleNamespace(
            motion=SimpleNamespace(v=v),
            used=slice(0, n),
            friction=lambda _: model,
            beside_rigid=lambda _: model + rest,
        )

    noise = np.where(slow, np.random.default_rng(0).normal(0.0, 0.5, n), 50.0)
    assert largest_friction(inverse(noise), {}) == 8.0
    assert largest_friction(inverse(-0.5 * model), {}) < 6.0


def test_the_largest_friction_of_a_law_that_holds_is_measured_at_rest():
    """The force rises to 3 N before each slip; the law would hold 50 N."""
    t = 1e-3 * np.arange(8000)
    part, way = t % 1.0, np.where(t % 2.0 < 1.0, 1.0, -1.0)
    v = 0.05 * way * np.where(part > 0.5, np.sin(2.0 * np.pi * part) ** 2, 0.0)
    force = way * np.where(part < 0.5, 6.0 * part, 2.0)
    law = friction_law("coulomb_stribeck")
    values = {"F_s": 50.0, "F_c": 2.0, "v_s": 1e-6, "delta": 1.0, "F_0": 0.0, "m": 0.0, "b": 0.0}
    with candidate_fmus(law.name) as fmus:
        log = Recording(t, 1e-3 * np.cumsum(v), force, source="it")
        model = InverseModel(fmus, log, law=law)
        assert largest_friction(model, {**values, "delay": 0.0}) == pytest.approx(3.0, rel=0.05)
