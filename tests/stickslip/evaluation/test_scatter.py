"""Published figures are medians over encoder phases, and have their ranges beside them."""

import numpy as np
import pandas as pd
import pytest

from stickslip.catalog.parameters import LUGRE, PAPER
from stickslip.evaluation.comparison import KEYS, Entry, evaluate
from stickslip.evaluation.motions import MOTIONS, VALIDATION
from stickslip.evaluation.validation import (
    PHASES,
    beginnings,
    repetitions,
    run_command,
    summary,
    validate,
)
from stickslip.rigs.fmu import rig_of
from stickslip.servo.axis import LOOP
from stickslip.servo.systems import paper_loop
from stickslip.servo.velocity_loop import design_velocity_loop

EXACT = {name: PAPER[name] for name in LUGRE}


@pytest.fixture(scope="module", params=[{}, {"noise": 1}], ids=["no noise", "noise"])
def drive(request):
    with rig_of(request.param) as rig:
        yield rig, design_velocity_loop(rig.datasheet.axis(PAPER["m"], PAPER["b"]), LOOP)


def test_the_phases_spread_over_a_step_and_show_the_same_position_at_first():
    assert len(PHASES) >= 8
    assert PHASES[0] == 0.0
    assert np.diff(sorted(PHASES)) == pytest.approx(1.0 / len(PHASES))
    assert np.abs(PHASES).max() < 0.5


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
    if not rig_is_noisy(whole):  # alone, each phase has the first seed
        each = np.array([one["with"] for one in single])
        np.testing.assert_array_equal(table["with"], np.median(each, axis=0))
        np.testing.assert_array_equal(table.with_low, each.min(axis=0))
        np.testing.assert_array_equal(table.with_high, each.max(axis=0))
    assert table.reduction.to_numpy() == pytest.approx(1.0 - table["with"] / table.without)
    assert (table.reduction_low <= table.reduction).all()
    assert (table.reduction <= table.reduction_high).all()
    assert "with_low" not in single[0]


def rig_is_noisy(validation):
    rest = validation.without.x_enc[:100]
    return np.ptp(rest) > 0.0


def test_motions_and_table_4_agree(drive):
    rig, loop = drive
    expected = validate(rig, loop, EXACT, VALIDATION, phases=PHASES).table()
    entries = {"without": Entry(loop), "with": Entry(loop, EXACT)}
    found = evaluate(rig, entries, motions=MOTIONS[:1], phases=PHASES)
    names = [f"{name}{end}" for name in entries for end in ("", "_low", "_high")]
    pd.testing.assert_frame_equal(found.table()[names], expected[names], check_exact=True)
    alone = run_command(rig, loop, EXACT, found.runs["trapezoid"]["with"].v_cmd)
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
