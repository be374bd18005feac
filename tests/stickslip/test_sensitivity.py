"""The slow motions test all five parameters, on drives of several kinds; the trapezoid does not."""

import numpy as np
import pandas as pd
import pytest

from stickslip.catalog.parameters import LUGRE, PAPER
from stickslip.evaluation.comparison import KEYS, Entry, evaluate
from stickslip.evaluation.motions import MOTIONS, SLOW_MOTIONS, Motion
from stickslip.evaluation.scatter import ONCE, PHASES
from stickslip.evaluation.validation import run_command, validate
from stickslip.papers.lugre.motion_study import (
    CONTROL,
    SEEN,
    WEAK_ENTRIES,
    by_motion,
    sensitivity,
    study_motions,
    unseen,
)
from stickslip.rigs.fmu import rig_of
from stickslip.servo.datasheet import LOOP
from stickslip.servo.filtered_loop import with_inertia, with_velocity_filter
from stickslip.servo.paper_commands import VALIDATION
from stickslip.servo.velocity_loop import design_velocity_loop

pytestmark = pytest.mark.slow

DRIVES = {
    "the paper's": {},
    "heavier": {
        "m": 12.0,
        "F_s": 20.0,
        "F_c": 12.0,
        "v_s": 2e-3,
        "sigma_0": 2e5,
        "sigma_1": 2e3,
    },
    "friction doubled": {name: 2 * PAPER[name] for name in ("F_s", "F_c", "sigma_0", "sigma_1")},
}
TRAPEZOID = MOTIONS[0]
REVERSALS, CREEP, MOVES = SLOW_MOTIONS


@pytest.fixture(scope="module", params=DRIVES)
def drive(request):
    """Return a rig, its loop and its true parameters."""
    changes = DRIVES[request.param]
    truth = {**PAPER, **changes}
    with rig_of(changes) as rig:
        yield rig, design_velocity_loop(rig.datasheet.axis(truth["m"], truth["b"]), LOOP), truth


@pytest.fixture(scope="module")
def study(drive):
    rig, loop, truth = drive
    exact = {name: truth[name] for name in LUGRE}
    filtered = with_inertia(with_velocity_filter(loop, rig.datasheet, truth["F_c"]))
    entries = {
        "without": Entry(loop),
        "learned": Entry(loop, exact),
        "filtered": Entry(filtered, exact),
        "half": Entry(loop, {**exact, "F_c": 0.5 * exact["F_c"]}),
    }
    return study_motions(rig, entries, loop, exact, phases=PHASES[:3])


@pytest.fixture(scope="module")
def paper():
    with rig_of({}) as rig:
        yield rig, design_velocity_loop(rig.datasheet.axis(PAPER["m"], PAPER["b"]), LOOP)


def test_each_wrong_parameter_is_seen_by_a_slow_motion(study):
    lost = by_motion(study.sensitivity)
    assert {name for name, _ in lost.index} == set(LUGRE)
    assert unseen(lost[[motion.name for motion in SLOW_MOTIONS]]) == []


def test_each_raises_an_rms_error_of_the_true_velocity_by_a_fifth_or_more(study):
    shown = study.sensitivity
    shown = shown[(shown.metric == "E_rms") & (shown.motion != TRAPEZOID.name)]
    rise = shown.wrong / shown.exact - 1.0
    rise = rise.groupby([shown.parameter, shown.change]).max().drop(index=CONTROL)
    assert (rise > 0.2).all()


def test_the_trapezoid_sees_neither_the_stribeck_peak_nor_its_width(study):
    missed = unseen(by_motion(study.sensitivity)[[TRAPEZOID.name]])
    assert {("F_s", "= F_c"), ("v_s", "/ 3")} <= set(missed)


def test_a_change_too_small_to_matter_costs_less_than_counts_as_seen(study):
    assert (by_motion(study.sensitivity).loc[CONTROL].abs() < 0.5 * SEEN).all()


def test_an_exact_compensator_makes_no_error_of_the_measured_motion_larger(study):
    table = study.evaluation.table()
    measured = table[table.velocity == "measured"]
    assert (measured.learned < measured.without).all()


def test_in_a_weak_loop_it_makes_creep_worse(paper):
    rig, loop = paper
    exact = {name: PAPER[name] for name in LUGRE}
    entries = {"without": Entry(loop), "learned": Entry(loop, exact)}
    study = study_motions(rig, entries, loop, exact, phases=ONCE)
    assert study.weak.K_p == pytest.approx(0.1 * loop.K_p)
    table = study.evaluation.table().set_index(KEYS)
    for region in ("0.1 mm/s", "0.3 mm/s"):
        row = table.loc[(CREEP.name, region, "true", "E_rms", "mm/s")]
        without, with_exact = row[list(WEAK_ENTRIES)]
        assert with_exact > without
        assert row.learned < row.without


def test_the_table_is_tidy(study):
    table = study.evaluation.table()
    entries = ["without", "learned", "filtered", "half", *WEAK_ENTRIES]
    ranges = [f"{name}_{end}" for name in entries for end in ("low", "high")]
    assert list(table.columns) == [*KEYS, *entries, *ranges]
    assert not table.duplicated(KEYS).any()
    assert np.isfinite(table[entries].to_numpy()).all()
    assert list(table.motion.unique()) == [motion.name for motion in MOTIONS]
    units = table.groupby("metric").unit.unique().map(list).to_dict()
    assert units == {"E_max": ["mm/s"], "E_rms": ["mm/s"], "E_x": ["um"]}
    positioned = set(table[table.metric == "E_x"].motion)
    assert positioned == {REVERSALS.name, MOVES.name}


def test_the_trapezoid_has_the_errors_of_table_4(paper):
    rig, loop = paper
    exact = {name: PAPER[name] for name in LUGRE}
    expected = validate(rig, loop, exact, VALIDATION).table()
    entries = {"without": Entry(loop), "with": Entry(loop, exact)}
    table = evaluate(rig, entries, motions=[TRAPEZOID]).table()
    columns = ["velocity", "region", "metric", "without", "with"]
    pd.testing.assert_frame_equal(table[columns], expected[columns], check_exact=True)


def test_each_entry_runs_in_its_own_loop_with_its_own_compensator(drive, study):
    """However they are grouped to prepare the FMUs once, the runs are those made one by one."""
    rig, loop, truth = drive
    exact = {name: truth[name] for name in LUGRE}
    filtered = with_inertia(with_velocity_filter(loop, rig.datasheet, truth["F_c"]))
    runs = study.evaluation.runs[MOVES.name]
    v_cmd = runs["without"].v_cmd
    for name, entry in (
        ("without", Entry(loop)),
        ("half", Entry(loop, {**exact, "F_c": 0.5 * exact["F_c"]})),
        ("filtered", Entry(filtered, exact)),
    ):
        alone = run_command(rig, entry.loop, entry.compensator, v_cmd)
        assert (alone.v["true"] == runs[name].v["true"]).all()


def test_the_position_error_is_the_largest_distance_from_where_the_command_leads(paper):
    """Without compensation a move of 5 um ends short of it by what the encoder shows."""
    rig, loop = paper
    (begin, _), *_ = MOVES.regions["5 um"]
    motion = Motion("one", "", MOVES.command, begin + 0.15, {"one": ((begin, begin + 0.15),)}, True)
    evaluation = evaluate(rig, {"without": Entry(loop)}, motions=[motion])
    run = evaluation.runs["one"]["without"]
    shown = evaluation.table().set_index(["metric", "velocity"])["without"]
    distance = 1e6 * np.cumsum(run.v_cmd - run.v["true"]) * LOOP.T_s
    assert shown["E_x", "true"] == pytest.approx(np.abs(distance).max(), abs=0.05)
    assert shown["E_x", "measured"] == pytest.approx(shown["E_x", "true"], abs=0.41)
    assert shown["E_x", "true"] > 2.0


def test_sensitivity_says_what_was_lost(drive):
    rig, loop, truth = drive
    exact = {name: truth[name] for name in LUGRE}
    shown = sensitivity(rig, loop, exact, motions=[MOVES], phases=PHASES[:3])
    found = (shown.wrong - shown.exact) / shown.without
    assert ((shown.lost - found).abs() <= shown.lost_high - shown.lost_low).all()
    assert set(shown.metric) == {"E_rms", "E_x"}
    assert len(shown) == 12 * 2 * len(MOVES.regions)
