"""The fit that ends the learning weighs the training run against identification."""

from dataclasses import replace

import pytest

from stickslip.identification import Estimate
from stickslip.learning import Study
from stickslip.parameters import LUGRE, PAPER
from stickslip.refinement import refine
from stickslip.setup import TRAINING


@pytest.fixture
def study(reproduction, make_rig):
    rig = make_rig()
    found = reproduction.identification
    v_cmd = TRAINING.sample(rig.samples(TRAINING.duration))
    return Study(rig, found.loop, found.estimates, v_cmd)


def start(study):
    return {name: study.start[name].value for name in LUGRE}


def test_it_corrects_what_the_training_run_shows(study):
    wrong = Estimate(PAPER["F_c"] * 1.05, 0.3)
    study = replace(study, start={**study.start, "F_c": wrong})
    found = refine(study, start(study))
    assert found.accepted
    assert found.values["F_c"] == pytest.approx(PAPER["F_c"], rel=0.005)


def test_it_leaves_what_the_training_run_hardly_shows_to_identification(study):
    found = refine(study, start(study))
    prior = study.start["F_s"]
    assert found.alone["F_s"] > 5 * found.alone["F_c"]
    assert found.values["F_s"] == pytest.approx(prior.value, rel=0.03)


def test_without_the_fit_the_start_stands(study):
    found = refine(study, start(study), fit=False)
    assert found.values == start(study)
    assert not found.accepted
    assert found.cost > 0


def test_stick_force_stays_above_coulomb_force(study):
    begin = start(study) | {"F_s": PAPER["F_c"], "F_c": PAPER["F_c"]}
    found = refine(study, begin)
    assert found.values["F_s"] >= found.values["F_c"]
