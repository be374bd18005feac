"""The commands of the motions do what their purpose says."""

import re

import numpy as np
import pytest

from stickslip.evaluation.motions import MOTIONS, SLOW_MOTIONS
from stickslip.servo.axis import LOOP

REVERSALS, CREEP, MOVES = SLOW_MOTIONS


def sampled(motion):
    t = np.arange(round(motion.duration / LOOP.T_s) + 1) * LOOP.T_s
    return t, motion.command.sample(t)


def region_of(motion, name, t):
    spans = motion.regions[name]
    return np.any([(t >= begin - 1e-9) & (t <= end + 1e-9) for begin, end in spans], axis=0)


def number_in(name):
    return float(re.match(r"[\d.]+", name)[0])


@pytest.mark.parametrize("motion", MOTIONS, ids=lambda motion: motion.name)
def test_a_motion_returns_to_rest_where_it_began_and_its_regions_do_not_overlap(motion):
    t, v = sampled(motion)
    assert v[0] == v[-1] == 0.0
    assert np.trapezoid(v, t) == pytest.approx(0.0, abs=1e-8)
    edges = [edge for spans in motion.regions.values() for edge in spans]
    edges = np.array(sorted(edges)).ravel()
    assert (np.diff(edges) > -1e-9).all()
    assert 0.0 < edges[0] < edges[-1] <= motion.duration


@pytest.mark.parametrize("name", REVERSALS.regions)
def test_a_reversal_is_followed_from_zero_to_the_peak(name):
    t, v = sampled(REVERSALS)
    for begin, end in REVERSALS.regions[name]:
        part = np.abs(v[(t >= begin - 1e-9) & (t <= end + 1e-9)])
        assert part[0] == pytest.approx(0.0, abs=1e-12)
        assert (np.diff(part) > 0.0).all()
        assert 1e3 * part[-1] == pytest.approx(number_in(name))


@pytest.mark.parametrize("name", CREEP.regions)
def test_creep_is_at_its_speed_in_both_directions(name):
    t, v = sampled(CREEP)
    v = 1e3 * v[region_of(CREEP, name, t)]
    speed = number_in(name)
    assert v.max() == pytest.approx(speed)
    assert v.min() == pytest.approx(-speed)
    steady = np.isclose(np.abs(v), speed)
    assert steady.mean() > 0.9
    assert np.trapezoid(v[v >= 0.0]) * LOOP.T_s == pytest.approx(0.2, rel=0.02)  # mm


@pytest.mark.parametrize("name", MOVES.regions)
def test_a_move_goes_as_far_as_its_name_says(name):
    t, v = sampled(MOVES)
    x = 1e6 * np.cumsum(v) * LOOP.T_s
    x = x[region_of(MOVES, name, t)]
    assert x.max() == pytest.approx(number_in(name))
    assert x.min() == pytest.approx(0.0, abs=1e-6)


def test_all_are_slower_than_the_trapezoid_is_judged_or_shorter_than_it_slides():
    for motion in (REVERSALS, CREEP):
        assert np.abs(sampled(motion)[1]).max() <= 2e-3
    assert np.abs(np.cumsum(sampled(MOVES)[1])).max() * LOOP.T_s <= 51e-6
