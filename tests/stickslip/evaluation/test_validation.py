"""Errors (8a), (8b) and (9), as medians over encoder phases, on motions that do what they say."""

import re

import numpy as np
import pandas as pd
import pytest

from stickslip.catalog.parameters import LUGRE, PAPER
from stickslip.evaluation.comparison import KEYS, Entry, evaluate
from stickslip.evaluation.motions import MOTIONS, REGION, SLOW_MOTIONS, VALIDATION, regions_after
from stickslip.evaluation.validation import (
    PHASES,
    beginnings,
    repetitions,
    runs_of,
    summary,
    tracking_errors,
    validate,
)
from stickslip.rigs.fmu import rig_of
from stickslip.servo.axis import LOOP
from stickslip.servo.systems import paper_loop
from stickslip.servo.velocity_loop import design_velocity_loop

T_S = 5e-4


def test_errors_count_inside_the_region_only():
    t = np.arange(2001) * T_S
    instant = 0.2
    inside = (t >= instant + REGION[0] - 1e-9) & (t <= instant + REGION[1] + 1e-9)
    (spans,) = regions_after({"start": instant}).values()
    assert tracking_errors(t, np.where(inside, 0.0, 9.0), spans)["E_max"] == 0.0
    error = np.zeros_like(t)
    error[np.flatnonzero(inside)[[0, -1]]] = 2.0
    found = tracking_errors(t, error, spans)
    assert found["E_max"] == 2.0
    assert found["E_rms"] == pytest.approx(np.sqrt(8.0 / inside.sum()))


def test_errors_over_several_spans_are_those_of_all_their_samples():
    t = np.arange(2001) * T_S
    error = np.where((t >= 0.1) & (t < 0.5), 1.0, -3.0)
    found = tracking_errors(t, error, [(0.1, 0.1 + 299 * T_S), (0.6, 0.6 + 99 * T_S)])
    assert found["E_max"] == 3.0
    assert found["E_rms"] == pytest.approx(np.sqrt((300 * 1.0 + 100 * 9.0) / 400))


EXACT = {name: PAPER[name] for name in LUGRE}


@pytest.fixture(scope="module", params=[{}, {"noise": 1}], ids=["no noise", "noise"])
def drive(request):
    with rig_of(request.param) as rig:
        yield rig, design_velocity_loop(rig.datasheet.axis(PAPER["m"], PAPER["b"]), LOOP)


def test_the_drive_begins_at_each_phase_with_other_noise(drive):
    rig, loop = drive
    starts = beginnings(paper_loop(rig.fmus, loop, None), PHASES)
    assert [one["drive.x"] / 4e-7 for one in starts] == pytest.approx(PHASES)
    assert [one["drive.seed"] for one in starts] == list(range(len(PHASES)))


def test_table_4_is_the_median_of_the_phases_with_its_range(drive):
    rig, loop = drive
    whole = validate(rig, loop, EXACT, VALIDATION, phases=PHASES)
    ends = [whole.without.x[0], *(without.x[0] for without, _ in whole.repeated)]
    assert ends == pytest.approx([4e-7 * phase for phase in PHASES])
    single = [validate(rig, loop, EXACT, VALIDATION, phases=[phase]).table() for phase in PHASES]
    table = whole.table()
    if not np.ptp(whole.without.x_enc[:100]):  # with noise, each phase alone has the first seed
        each = np.array([one["with"] for one in single])
        np.testing.assert_array_equal(table["with"], np.median(each, axis=0))
        np.testing.assert_array_equal(table.with_low, each.min(axis=0))
        np.testing.assert_array_equal(table.with_high, each.max(axis=0))
    assert table.reduction.to_numpy() == pytest.approx(1.0 - table["with"] / table.without)
    assert (table.reduction_low <= table.reduction).all()
    assert (table.reduction <= table.reduction_high).all()
    assert "with_low" not in single[0]


def test_motions_and_table_4_agree(drive):
    rig, loop = drive
    expected = validate(rig, loop, EXACT, VALIDATION, phases=PHASES).table()
    entries = {"without": Entry(loop), "with": Entry(loop, EXACT)}
    found = evaluate(rig, entries, motions=MOTIONS[:1], phases=PHASES)
    names = [f"{name}{end}" for name in entries for end in ("", "_low", "_high")]
    pd.testing.assert_frame_equal(found.table()[names], expected[names], check_exact=True)
    alone = next(runs_of(rig, loop, [EXACT], found.runs["trapezoid"]["with"].v_cmd))[0]
    assert (alone.x == found.runs["trapezoid"]["with"].x).all()


def test_seeds_and_phases_count_alike(drive):
    rig, loop = drive
    other = {**EXACT, "F_c": 0.5 * EXACT["F_c"]}
    entries = {"two": Entry(loop, EXACT, [other])}
    errors = evaluate(rig, entries, motions=MOTIONS[:1], phases=PHASES[:2]).errors["two"]
    assert errors.shape == (8, 4)
    assert list(errors.index.names) == KEYS


def test_a_run_that_runs_away_leaves_no_median():
    found = repetitions([{"a": 1.0, "b": 1.0}, {"a": 3.0, "b": np.nan}], ["key"])
    table = summary({"x": found})
    assert list(table.columns) == ["x", "x_low", "x_high"]
    assert table.loc["a"].tolist() == [2.0, 1.0, 3.0]
    assert table.loc["b"].isna().all()


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
