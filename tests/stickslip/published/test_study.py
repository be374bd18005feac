"""The paper's learning as published, from coarse starts over seeds."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from stickslip import ga
from stickslip.catalog.parameters import LUGRE
from stickslip.evaluation.validation import validate
from stickslip.identification.stages import Estimate
from stickslip.rigs.fmu import rig_of
from stickslip.servo.paper_commands import TRAINING, VALIDATION
from stickslip.tuning.coarse_start import coarsened, draw_factors
from stickslip.tuning.learning import VelocityCost
from stickslip.tuning.published.readings import (
    evaluation_readings,
    rounded_absolutely,
    rounded_relatively,
    threshold_reading,
    worse,
)
from stickslip.tuning.published.study import Method, learn_as_published

pytestmark = pytest.mark.slow

SHORT = Method(replace(ga.PAPER, generations=10), width=2.0)
"""Starts twice as coarse, from which a tenth of the generations shows what learning does."""
SEEDS = range(6)


@pytest.fixture(scope="module")
def drive(reproduction):
    with rig_of({}) as rig:
        yield rig, reproduction.identification.loop, reproduction.identification.estimates


@pytest.fixture(scope="module")
def published(drive):
    return learn_as_published(*drive, SEEDS, SHORT, workers=2)


def test_from_coarse_starts_the_cost_falls_by_half_in_the_median(published):
    assert np.median(published.final_costs() / published.start_costs()) < 0.5


def test_from_the_identified_values_there_is_nothing_to_learn(drive):
    """The flat line of Fig. 5 that an accurate identification leaves."""
    exact = learn_as_published(*drive, range(1), replace(SHORT, width=0.0))
    assert exact.final_costs()[0] > 0.5 * exact.start_costs()[0]


def test_seeds_side_by_side_learn_what_they_learn_alone(drive, published):
    alone = learn_as_published(*drive, [3], SHORT)
    together = published.fitness()
    pd.testing.assert_frame_equal(
        alone.fitness(), together[together["seed"] == 3].reset_index(drop=True)
    )


def test_runs_are_counted_as_in_the_paper(published):
    last = published.fitness().groupby("seed").tail(1)
    assert (last["runs"] == 10 * 10).all()
    assert (last["evaluations"] == 10 + 9 * 8).all()


def test_each_seed_starts_at_the_identified_values_times_its_factors(drive, published):
    found = drive[2]
    for one in published.seeds:
        start = coarsened(found, draw_factors(one.seed, width=2.0))
        assert one.start == {name: start[name].value for name in LUGRE}
        first = one.algorithm.history.iloc[0]
        for name in LUGRE:  # Table 3's resolution, of a range of 100 times the start
            assert first[name] == pytest.approx(one.start[name], rel=0.01)


def test_the_costs_and_errors_are_those_of_single_runs(drive, published):
    rig, loop, _ = drive
    one = published.seeds[0]
    v_cmd = TRAINING.sample(rig.samples(TRAINING.duration))
    with rig.cost_of(v_cmd, loop, VelocityCost(rig.T_s)) as cost:
        assert published.final_costs()[0] == cost(np.array([one.learned[n] for n in LUGRE]))
    table = published.table4()
    table = table[table["seed"] == one.seed].reset_index(drop=True)
    for column, values in (("start", one.start), ("with", one.learned)):
        expected = validate(rig, loop, values, VALIDATION).table()
        np.testing.assert_array_equal(table[column], expected["with"])


def test_the_training_run_without_compensation_costs_more_than_with(published):
    assert published.cost_without > 3 * np.median(published.final_costs())


def test_a_changed_exponent_and_filter_reach_the_drive_and_the_cost(drive, published):
    for changes in ({"delta": 2.0}, {"cutoff": None}, {"feed": "command"}):
        settings = replace(ga.PAPER, generations=1)
        method = replace(SHORT, settings=settings, **changes)
        other = learn_as_published(*drive, range(1), method)
        assert other.start_costs()[0] != published.start_costs()[0], changes


def test_worse_counts_seeds_by_both_regions_together():
    rows = [
        (0, "start", 1.0, 2.0),
        (0, "reverse", 3.0, 1.0),  # better in all
        (1, "start", 1.0, 0.5),
        (1, "reverse", 1.0, 2.0),  # worse in all
    ]
    table = pd.DataFrame(rows, columns=["seed", "region", "start", "with"]).assign(metric="E_rms")
    assert worse(table) == 0.5


def test_readings_of_the_evaluation_agree_with_table_4_where_they_are_ours(published):
    readings = evaluation_readings(published)
    table = published.table4()
    for velocity, reading in (("measured", readings[readings["ours"]]), ("true", readings.tail(1))):
        rows = table[table["velocity"] == velocity]
        median = rows.groupby(["region", "metric"])["with"].median()
        for region, metric in median.index:
            np.testing.assert_allclose(reading[f"with_{region}_{metric}"], median[region, metric])
    wider = readings[readings["reading"] == "from 0 to 70 ms"].iloc[0]
    ours = readings[readings["ours"]].iloc[0]
    assert wider["without_start_E_rms"] < 0.95 * ours["without_start_E_rms"]


def test_a_threshold_that_all_reach_at_once_leaves_their_start(published):
    at_once = threshold_reading(published, threshold=1.0)
    assert at_once["stops"] == 1.0
    assert at_once["generations"] == 1.0
    first = [one.algorithm.convergence()["best_cost"].iloc[0] for one in published.seeds]
    assert at_once["cost"] == np.median(first)
    never = threshold_reading(published, threshold=0.0)
    assert never["stops"] == 0.0
    assert never["cost"] == np.median(published.final_costs())


def test_rounded_candidates_lie_on_the_stated_steps():
    values = np.array([[8.99912, 5.57e-4, 391234.5]])
    np.testing.assert_allclose(rounded_absolutely(values, []), [[8.9991, 6e-4, 391234.5]])
    rounded = rounded_relatively(values, [])
    np.testing.assert_allclose(rounded, values, rtol=0.51e-4)
    steps = np.log(rounded) / 1e-4
    np.testing.assert_allclose(steps, np.rint(steps), atol=1e-6)


def test_a_coarse_start_has_the_stated_spread_and_order():
    logs = np.log([[draw_factors(seed)[name] for name in LUGRE] for seed in range(2000)])
    np.testing.assert_allclose(logs.mean(axis=0), 0.0, atol=0.05)
    np.testing.assert_allclose(logs.std(axis=0), [0.2, 0.2, 0.7, 0.35, 0.35], rtol=0.05)
    found = {name: Estimate(1.0, 0.1) for name in LUGRE} | {"F_s": Estimate(1.1, 0.1)}
    start = coarsened(found, {"F_s": 0.5, "F_c": 2.0})
    assert start["F_s"].value == 2.0
    assert start["F_c"].value == pytest.approx(0.55)
