"""Entries compared on motions: the slow ones see every parameter, the trapezoid does not."""

import numpy as np
import pytest

from stickslip.catalog.parameters import LUGRE, PAPER
from stickslip.evaluation.comparison import KEYS, Entry, evaluate
from stickslip.evaluation.motions import MOTIONS, SLOW_MOTIONS, Motion
from stickslip.evaluation.validation import PHASES, runs_of
from stickslip.rigs.fmu import rig_of
from stickslip.servo.axis import LOOP
from stickslip.servo.tuned_pi import with_inertia, with_velocity_filter
from stickslip.servo.velocity_loop import design_velocity_loop
from tests.kept import further

pytestmark = pytest.mark.slow

DRIVES = {
    "the paper's": {},
    "heavier": {"m": 12.0, "F_s": 20.0, "F_c": 12.0, "v_s": 2e-3, "sigma_0": 2e5, "sigma_1": 2e3},
    "friction doubled": {name: 2 * PAPER[name] for name in ("F_s", "F_c", "sigma_0", "sigma_1")},
}
FACTORS = dict.fromkeys(LUGRE, (0.5, 2.0)) | {"v_s": (1 / 3, 3.0)}
SEEN = 0.10
"""A motion sees that a parameter is wrong where that costs this much of the reduction (9)."""
TRAPEZOID = MOTIONS[0]
REVERSALS, CREEP, MOVES = SLOW_MOTIONS


@pytest.fixture(scope="module", params=["heavier", *further("the paper's", "friction doubled")])
def drive(request):
    """Return a rig, its loop and its friction."""
    truth = {**PAPER, **DRIVES[request.param]}
    with rig_of(DRIVES[request.param]) as rig:
        loop = design_velocity_loop(rig.datasheet.axis(truth["m"], truth["b"]), LOOP)
        yield rig, loop, {name: truth[name] for name in LUGRE}


@pytest.fixture(scope="module")
def paper():
    exact = {name: PAPER[name] for name in LUGRE}
    with rig_of({}) as rig:
        yield rig, design_velocity_loop(rig.datasheet.axis(PAPER["m"], PAPER["b"]), LOOP), exact


@pytest.fixture(scope="module")
def compared(drive):
    rig, loop, exact = drive
    filtered = with_inertia(with_velocity_filter(loop, rig.datasheet, exact["F_c"]))
    wrong = {("F_s", "F_c"): {**exact, "F_s": exact["F_c"]}}
    wrong |= {(n, x): {**exact, n: x * exact[n]} for n in LUGRE for x in FACTORS[n]}
    entries = {
        "without": Entry(loop),
        "exact": Entry(loop, exact),
        "filtered": Entry(filtered, exact),
        **{key: Entry(loop, values) for key, values in wrong.items()},
    }
    return evaluate(rig, entries, phases=PHASES[:3]), [*wrong]


def test_each_wrong_parameter_is_seen_by_a_slow_motion_and_not_by_the_trapezoid(compared):
    evaluation, wrong = compared
    table = evaluation.table().set_index(KEYS).xs("true", level="velocity")
    table = table[table.index.get_level_values("metric") != "E_max"]
    lost = table[wrong].sub(table["exact"], axis=0).div(table["without"], axis=0)
    lost = lost.groupby("motion").max()
    assert (lost.loc[[motion.name for motion in SLOW_MOTIONS]].max() >= SEEN).all()
    assert (lost.loc[TRAPEZOID.name, [("F_s", "F_c"), ("v_s", 1 / 3)]] < SEEN).all()


def test_an_exact_compensator_makes_no_error_of_the_measured_motion_larger(compared):
    table = compared[0].table()
    measured = table[table.velocity == "measured"]
    assert (measured.exact < measured.without).all()


def test_each_entry_runs_in_its_own_loop_with_its_own_compensator(drive, compared):
    """However they are grouped to prepare the FMUs once, the runs are those made one by one."""
    rig, loop, exact = drive
    filtered = with_inertia(with_velocity_filter(loop, rig.datasheet, exact["F_c"]))
    runs = compared[0].runs[MOVES.name]
    v_cmd = runs["without"].v_cmd
    half = {**exact, "F_c": 0.5 * exact["F_c"]}
    tried = (("without", loop, None), (("F_c", 0.5), loop, half), ("filtered", filtered, exact))
    for name, own, compensator in tried:
        alone = next(runs_of(rig, own, [compensator], v_cmd))[0]
        assert (alone.v["true"] == runs[name].v["true"]).all()


def test_the_position_error_is_the_largest_distance_from_where_the_command_leads(paper):
    """Without compensation a move of 5 um ends short of it by what the encoder shows."""
    rig, loop, _ = paper
    (begin, _), *_ = MOVES.regions["5 um"]
    motion = Motion("one", "", MOVES.command, begin + 0.15, {"one": ((begin, begin + 0.15),)}, True)
    evaluation = evaluate(rig, {"without": Entry(loop)}, motions=[motion])
    run = evaluation.runs["one"]["without"]
    shown = evaluation.table().set_index(["metric", "velocity"])["without"]
    distance = 1e6 * np.cumsum(run.v_cmd - run.v["true"]) * LOOP.T_s
    assert shown["E_x", "true"] == pytest.approx(np.abs(distance).max(), abs=0.05)
    assert shown["E_x", "measured"] == pytest.approx(shown["E_x", "true"], abs=0.41)
    assert shown["E_x", "true"] > 2.0
