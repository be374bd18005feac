"""Where learning helps, it helps by far; where it cannot, it is skipped and says why."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from stickslip import ga
from stickslip.catalog.parameters import LUGRE, PAPER
from stickslip.commands.assignments import coarse_factors
from stickslip.errors import UsageError
from stickslip.identification.stages import identify
from stickslip.servo.datasheet import LOOP
from stickslip.servo.paper_commands import TRAINING
from stickslip.tuning.coarse_start import coarsened, draw_factors
from stickslip.tuning.learning import Study, learn
from stickslip.tuning.refinement import refine

pytestmark = pytest.mark.slow

COARSE = {"F_s": 0.7, "F_c": 0.7, "v_s": 3.0, "sigma_0": 0.5, "sigma_1": 0.5}
EXTRAS = {"asymmetric": True, "position_dependent": True, "ripple": True, "noise": True}


def study_of(rig, factors=None, **options):
    found = identify(rig, LOOP)
    start = {name: found.estimates[name] for name in LUGRE}
    if factors is not None:
        start = coarsened(start, factors)
    v_cmd = TRAINING.sample(rig.samples(TRAINING.duration))
    return Study(rig, found.loop, start, v_cmd, **options)


def values_of(study):
    return {name: known.value for name, known in study.start.items()}


def learned(study):
    """Return what the default learns, in a third of its generations."""
    short = replace(study, settings=replace(ga.DEFAULT, generations=35))
    return refine(short, short.parameters(learn(short).best.values))


@pytest.mark.parametrize(
    ("truth", "seed"),
    [({}, 0), pytest.param({"m": 8.0, "F_c": 4.0}, 2, marks=pytest.mark.thorough)],
    ids=["paper", "heavy, another seed"],
)
def test_from_a_coarse_start_the_default_does_what_exact_parameters_do(
    make_rig, reductions, truth, seed
):
    study = study_of(make_rig(**truth), COARSE, seed=seed)
    exact = reductions(
        study.rig, study.loop, {name: (PAPER | truth)[name] for name in LUGRE}, "measured"
    )
    found = reductions(study.rig, study.loop, learned(study).values, "measured")
    assert (found > exact - 0.015).all()
    if not truth:
        assert (found.round(2) >= [0.95, 0.98, 0.96, 0.98]).all()


@pytest.mark.thorough
def test_with_all_extras_learning_beats_its_coarse_start_and_reaches_identification(
    make_rig, reductions
):
    rig = make_rig(**EXTRAS)
    study = study_of(rig, COARSE)
    identified = reductions(study.rig, study.loop, values_of(study_of(rig)), "true")
    found = reductions(study.rig, study.loop, learned(study).values, "true")
    assert (found > reductions(study.rig, study.loop, values_of(study), "true") + 0.1).all()
    assert (found > identified - 0.03).all()
    assert found[1] > identified[1] + 0.005  # friction differs between the directions


def crossing(algorithm, settings):
    """Return the mean probability with which a pair of parents was crossed (7)."""
    population, chances = np.empty(0), []
    for _, children in algorithm.history.groupby("generation"):
        elite = population[: settings.elites]
        population = np.sort(np.concatenate([elite, children["cost"].to_numpy()]))
        fitness = ga.fitness(population)
        drawn = np.outer(fitness, fitness) / fitness.sum() ** 2
        better = np.maximum.outer(fitness, fitness)
        P_c = ga.crossover_probability(
            better.ravel(), best=fitness.max(), mean=fitness.mean(), k1=settings.k1, k2=settings.k2
        )
        chances.append(float((drawn * P_c.reshape(drawn.shape)).sum()))
    return np.mean(chances)


def test_the_papers_crossover_acts_from_coarse_starts_and_never_on_a_flat_line(make_rig):
    settings = replace(ga.PAPER, generations=12)
    study = study_of(make_rig(), settings=settings, seed=1)
    assert crossing(learn(study), settings) < 1e-3
    starts = [coarsened(study.start, draw_factors(seed, 2.0)) for seed in range(1, 4)]
    chances = [crossing(learn(replace(study, start=start)), settings) for start in starts]
    assert np.median(chances) > 0.02


def test_on_the_papers_drive_the_default_skips_the_search_and_says_why(reproduction, results):
    learned, identified = reproduction.refinement, reproduction.identification.estimates
    skipped = learned.skipped
    assert "no parameters would bring that below" in skipped
    for name in LUGRE:
        assert learned.estimates[name] == identified[name]
    document = json.loads((results / "learned.json").read_text())
    assert document["search_skipped"] == skipped
    assert document["result"] == "start"
    assert len(pd.read_csv(results / "fitness.csv")) == 1
    page = (results / "report.html").read_text(encoding="utf-8")
    assert "Nothing was searched" in page
    assert skipped.replace("m2/s2", "m²/s²") in page


def test_a_coarse_start_is_stated_on_the_command_line():
    assert coarse_factors(["F_c=0.7", "v_s=3"]) == {"F_c": 0.7, "v_s": 3.0}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("m=2", "expected one of F_s, F_c"),
        ("F_c=-1", "positive number"),
        ("F_c=0", "positive number"),
        ("F_c=nan", "positive number"),
        ("F_c=inf", "positive number"),
        ("F_c=much", "must be a number"),
        ("F_c", "expected NAME=VALUE"),
    ],
)
def test_a_coarse_start_that_makes_no_sense_is_refused(text, message):
    with pytest.raises(UsageError, match=f"--coarse.*{message}"):
        coarse_factors([text])
