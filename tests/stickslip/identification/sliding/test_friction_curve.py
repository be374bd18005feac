"""Mass, offset, friction against speed and its rise without a law, on motions with closed forms."""

import numpy as np
import pytest

from stickslip.identification.sliding.friction_curve import FrictionCurve, friction_curve
from stickslip.identification.sliding.stribeck import EXPONENTS, rise
from stickslip.thresholds import curve_shown

T_S = 5e-4
M, B, F_C, F_S, V_S, F_0 = 3.0, 20.0, 4.0, 7.0, 2e-3, 0.8
STEP = 4e-7


def curve(v: np.ndarray, delta: float = 1.0, F_s: float = F_S) -> np.ndarray:
    return F_C + (F_s - F_C) * np.exp(-((v / V_S) ** delta)) + B * v


def recorded(
    seed: int, *, guide: float = 0.0, asymmetry: float = 0.0, ripple: float = 0.0
) -> FrictionCurve:
    """Return the curve of sines whose amplitude and frequency vary, logged with steps and noise."""
    rng = np.random.default_rng(seed)
    t = np.arange(40_000) * T_S
    phase = 2.0 * np.pi * (0.15 * t + 0.5 * (2.0 / 20.0) * t**2)
    x = 0.012 * np.sin(phase) + 0.004 * np.sin(2.0 * np.pi * 0.11 * t)
    v = np.gradient(x, T_S)
    a = np.gradient(v, T_S)
    here = 1.0 + guide * np.sin(2.0 * np.pi * x / 0.004) + asymmetry * np.sign(v)
    magnitude = here * (curve(np.abs(v)) - B * np.abs(v))
    turns = np.where(np.diff(np.sign(v), prepend=0.0), np.arange(len(v)), 0)
    since = np.abs(x - x[np.maximum.accumulate(turns)])  # friction turns over 20 um
    bent = 1.0 - 2.0 * np.exp(-since / 2e-5)
    force = M * a + B * v + np.sign(v) * bent * magnitude + F_0
    force += ripple * np.sin(2.0 * np.pi * x / 0.009)
    shown = STEP * np.round((x + 1e-7 * rng.standard_normal(len(x))) / STEP)
    found = friction_curve(shown, force + 0.05 * rng.standard_normal(len(x)), T_S, STEP)
    assert found is not None
    return found


def holds(found: FrictionCurve, offset: float) -> np.ndarray:
    """Return whether the intervals of m, b, the offset and of the friction at each speed hold."""
    truth = [M, B, offset, *curve(found.speed)]
    low = [one.low for one in (found.mass, found.viscous, found.offset)] + list(found.low)
    high = [one.high for one in (found.mass, found.viscous, found.offset)] + list(found.high)
    return (np.array(low) <= truth) & (truth <= np.array(high))


def test_a_plain_drive_is_found_within_narrow_intervals() -> None:
    found = recorded(0)
    assert found.mass.low <= M <= found.mass.high
    assert found.mass.high - found.mass.low < 0.04 * M
    assert found.value == pytest.approx(curve(found.speed), rel=0.01)
    assert np.all(found.high - found.low < 0.1 * found.value)
    assert all(force < curve_shown.VARIES * F_C for force in found.varying.values())


@pytest.mark.thorough
def test_intervals_hold_where_friction_varies_and_what_varies_is_known_by_its_size() -> None:
    """Friction that differs between the directions is an offset."""
    found = recorded(1, guide=0.1, ripple=0.5, asymmetry=0.15)
    assert holds(found, F_0 + 0.15 * F_C).mean() > 0.75
    assert found.varying.keys() >= {"guide", "ripple"}
    assert found.varying["ripple"] == pytest.approx(0.5 / np.sqrt(2.0), rel=0.2)
    assert found.offset.value == pytest.approx(F_0 + 0.15 * F_C, abs=0.05)
    assert found.value == pytest.approx(curve(found.speed), rel=0.02)


@pytest.mark.parametrize("delta", EXPONENTS)
def test_intervals_hold_the_values_of_a_curve_that_reaches_rest(delta: float) -> None:
    speed, rng = np.geomspace(0.3 * V_S, 40.0 * V_S, 12), np.random.default_rng(0)
    held = []
    for _ in range(40):
        value = curve(speed, delta) + 0.05 * rng.standard_normal(12)
        found = rise(speed, value, 0.05**2 * np.eye(12), delta)
        assert found is not None
        assert found.F_s[2] < 1.3 * found.F_s[1]
        held += [found.F_s[1] <= F_S <= found.F_s[2], found.v_s[1] <= V_S <= found.v_s[2]]
    assert np.mean(held) > 0.9


@pytest.mark.parametrize("lowest", [4.0 * V_S, 0.3 * V_S], ids=["too fast", "level"])
def test_what_a_curve_does_not_show_has_no_value(lowest: float) -> None:
    F_s = F_S if lowest > V_S else F_C
    speed = np.geomspace(lowest, 40.0 * V_S, 12)
    assert rise(speed, curve(speed, 1.0, F_s), 0.05**2 * np.eye(12), 1.0) is None
    x = 1e-6 * np.sin(np.arange(40_000) * T_S)  # hardly slides
    assert friction_curve(STEP * np.round(x / STEP), x, T_S, STEP) is None


def test_another_exponent_explains_less_of_the_curve() -> None:
    speed = np.geomspace(0.3 * V_S, 40.0 * V_S, 12)
    right, wrong = (rise(speed, curve(speed, 2.0), 0.01**2 * np.eye(12), one) for one in (2.0, 1.0))
    assert right is not None
    assert wrong is None or wrong.deviance > 4.0 * right.deviance
