"""Least squares on runs of the drive: what they find, and what of it is kept."""

from dataclasses import replace

import pytest

from stickslip.catalog.parameters import LUGRE, PAPER
from stickslip.evaluation.comparison import Entry, evaluate
from stickslip.evaluation.motions import TRAINING
from stickslip.identification.stages import Estimate, identify
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.axis import LOOP, Datasheet
from stickslip.tuning.learning import Study, coarsened, draw_factors
from stickslip.tuning.refinement import refine
from tests.kept import further

pytestmark = pytest.mark.slow


@pytest.fixture
def study(identified, fmus):
    return study_of(FmuRig(fmus, Datasheet(), LOOP.T_s), identified)


def start(study):
    return {name: study.start[name].value for name in LUGRE}


@pytest.mark.thorough
def test_it_corrects_what_the_training_run_shows_and_leaves_the_rest_to_identification(study):
    wrong = Estimate(PAPER["F_c"] * 1.05, 0.3)
    study = replace(study, start={**study.start, "F_c": wrong})
    found = refine(study)
    assert found.accepted
    assert found.values["F_c"] == pytest.approx(PAPER["F_c"], rel=0.005)
    assert found.alone["F_s"] > 5 * found.alone["F_c"]
    assert found.values["F_s"] == pytest.approx(study.start["F_s"].value, rel=0.03)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", [0, 5])
def test_from_a_coarse_start_it_finds_friction_with_fewer_runs_than_ten_generations(study, seed):
    found = refine(replace(study, start=coarsened(study.start, draw_factors(seed))))
    assert found.runs < 100
    assert found.values["F_c"] == pytest.approx(PAPER["F_c"], rel=0.005)
    assert found.values["sigma_0"] == pytest.approx(PAPER["sigma_0"], rel=0.15)


def study_of(rig, found=None):
    found = found or identify(rig, LOOP)
    v_cmd = TRAINING.sample(rig.samples(TRAINING.duration))
    return Study(rig, found.loop, {name: found.estimates[name] for name in LUGRE}, v_cmd)


@pytest.mark.thorough
def test_a_start_that_happens_to_fit_one_half_of_the_guide_does_not_stand(make_rig):
    rig = make_rig(position_dependent=True, position_amplitude=0.3, position_period=0.05)
    study = study_of(rig)
    low = {"F_c": 0.72, "F_s": 0.72}
    coarse = replace(study, start=coarsened(study.start, low))
    assert refine(coarse).values["F_c"] == pytest.approx(PAPER["F_c"], rel=0.02)


def errors_of(study, values):
    """Return RMS velocity and largest position errors in all motions, measured and true."""
    table = evaluate(study.rig, {"found": Entry(study.loop, values)}).table()
    table = table[table["metric"] != "E_max"]
    return table.set_index(["motion", "region", "velocity", "metric"])["found"]


@pytest.mark.parametrize(
    ("law", "seed"),
    [
        ("lugre", 2),
        *further(("gms", 0), ("leuven", 3), ("elasto_plastic", 1), ("coulomb_stribeck", 4)),
    ],
)
def test_what_is_kept_is_in_no_motion_worse_than_what_learning_began_with(
    study, make_rig, law, seed
):
    """By F_s and v_s a fit to the training command leaves 6 times the error in creep."""
    study = study if law == "lugre" else study_of(make_rig(law=law))
    study = replace(study, start=coarsened(study.start, draw_factors(seed)))
    found = refine(study)
    ratios = errors_of(study, found.values) / errors_of(study, start(study))
    assert ratios.max() < 1.2, ratios.nlargest(3)
    if law == "lugre":  # the guard must not cost what a sound drive can learn
        assert found.accepted
        assert ratios.median() < 0.6


@pytest.mark.thorough
def test_a_result_that_is_worse_at_slow_reversals_is_not_taken(make_rig):
    """A current loop ten times slower than its data sheet says looks like stiffness when fast."""
    study = study_of(make_rig(tau_i=1e-3))
    found = refine(study)
    assert not found.accepted
    assert found.values == start(study)
