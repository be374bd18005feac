"""The learning of the paper as published, least squares from the same starts, and the command."""

from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd
import pytest

from stickslip import ga
from stickslip.catalog.parameters import LUGRE
from stickslip.cli import main
from stickslip.evaluation.motions import TRAINING, VALIDATION
from stickslip.evaluation.validation import validate
from stickslip.identification.stages import Estimate
from stickslip.papers.lugre import published
from stickslip.papers.lugre.folder import PUBLISHED_FILES
from stickslip.papers.lugre.published import LOGARITHMIC, OURS, SQUARES, START, study_as_published
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.axis import LOOP, Datasheet
from stickslip.tuning.learning import VelocityCost, coarsened, draw_factors
from tests.stickslip.conftest import blank

pytestmark = pytest.mark.slow

SEEDS = range(2)
SHORT = replace(ga.PAPER, generations=6)
"""Few of the generations show what learning does."""


@pytest.fixture(scope="module", autouse=True)
def few_phases():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(published, "PHASES", published.PHASES[:3])
        yield


@pytest.fixture(scope="module")
def drive(identified, fmus):
    return FmuRig(fmus, Datasheet(), LOOP.T_s), identified


@pytest.fixture(scope="module")
def study(drive):
    return study_as_published(*drive, SEEDS, settings=SHORT, workers=2)


@pytest.mark.thorough
def test_the_search_lowers_the_cost_and_least_squares_does_so_in_a_fraction_of_its_runs(study):
    panel = study.panel().set_index("method")
    assert panel.seeds.tolist() == [2, 2, 2, 2]
    assert panel.runs[SQUARES] < panel.runs[OURS]
    for name in ("cost", "trapezoid", "slow_reversals", "creep", "micrometre_moves"):
        assert panel[name][SQUARES] < panel[name][OURS]
        assert panel[f"{name}_low"][OURS] <= panel[name][OURS] <= panel[f"{name}_high"][OURS]
    for method in (OURS, LOGARITHMIC):
        ratio = study.costs(method) / study.costs(START)
        assert (ratio <= 1.01).all()  # up to Table 3's resolution, to which the start is rounded
        assert np.median(ratio) < 0.9
    assert study.cost_without > 3 * np.median(study.costs(OURS))


@pytest.mark.thorough
def test_seeds_side_by_side_learn_what_they_learn_alone(drive, study):
    alone = study_as_published(*drive, [1], settings=SHORT)
    last = study.fitness().groupby("seed").tail(1)
    assert (last["runs"] == 6 * 10).all()  # counted as in the paper
    assert (last["evaluations"] == 10 + 5 * 8).all()
    for name in ("fitness", "learned"):
        together = study.tables()[name]
        together = together[together["seed"] == 1].reset_index(drop=True)
        pd.testing.assert_frame_equal(alone.tables()[name], together)


@pytest.mark.thorough
def test_each_seed_starts_at_the_identified_values_times_its_factors(drive, study):
    for start, ours in zip(study.seeds[START], study.seeds[OURS], strict=True):
        expected = coarsened(drive[1].estimates, draw_factors(start.seed))
        assert start.parameters == {name: expected[name].value for name in LUGRE}
        first = ours.algorithm.history.iloc[0]
        for name in LUGRE:  # Table 3's resolution, of a range of 100 times the start
            assert first[name] == pytest.approx(start.parameters[name], rel=0.01)


@pytest.mark.thorough
def test_costs_and_errors_are_those_of_single_runs(drive, study):
    rig, identified = drive
    loop = identified.loop
    v_cmd = TRAINING.sample(rig.samples(TRAINING.duration))
    with rig.cost_of(v_cmd, loop, VelocityCost(rig.T_s)) as cost:
        for runs in study.seeds.values():
            assert runs[0].cost == cost(np.array([runs[0].parameters[n] for n in LUGRE]))
    errors = study.evaluation.errors[SQUARES].loc["trapezoid"].droplevel("unit")
    expected = validate(rig, loop, study.seeds[SQUARES][0].parameters, VALIDATION).errors()
    for row in expected.to_dict("records"):
        found = errors.loc[row["region"], row["velocity"], row["metric"]].iloc[0]
        assert found == row["with"]


def test_a_coarse_start_has_the_stated_spread_and_order():
    logs = np.log([[draw_factors(seed)[name] for name in LUGRE] for seed in range(2000)])
    np.testing.assert_allclose(logs.mean(axis=0), 0.0, atol=0.05)
    np.testing.assert_allclose(logs.std(axis=0), [0.2, 0.2, 0.7, 0.35, 0.35], rtol=0.05)
    found = {name: Estimate(1.0, 0.1) for name in LUGRE} | {"F_s": Estimate(1.1, 0.1)}
    start = coarsened(found, {"F_s": 0.5, "F_c": 2.0})
    assert start["F_s"].value == 2.0
    assert start["F_c"].value == pytest.approx(0.55)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return what the command writes, with two generations."""
    folder = tmp_path_factory.mktemp("published") / "results"
    drive = ["--set", "drive.F_c=4", "drive.F_s=5", "drive.m=8"]
    command = ["reproduce", "--as-published", "--seeds", "1", "--seed", "6"]
    short = partial(published.study_as_published, settings=replace(ga.PAPER, generations=2))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(published, "study_as_published", short)
        patch.setattr("stickslip.presentation.page.Picture.of", blank)
        assert main([*command, "--out", str(folder), *drive]) == 0
    return folder


@pytest.mark.thorough
def test_all_files_are_there_and_tell_the_seed(folder):
    assert {path.name for path in folder.iterdir()} == {*PUBLISHED_FILES, "manifest.json"}
    for name in ("fitness", "learned"):
        assert set(pd.read_csv(folder / f"{name}.csv")["seed"]) == {6}
    panel = pd.read_csv(folder / "panel.csv")
    assert panel["method"].tolist() == ["start", "as_published", "logarithmic", "least_squares"]


@pytest.mark.parametrize("option", [["--mode", "record"], ["--algorithm", "cma"]], ids=" ".join)
def test_options_that_mean_nothing_to_it_are_refused(option, tmp_path, capsys):
    out = tmp_path / "results"
    assert main(["reproduce", "--as-published", "--out", str(out), *option]) != 0
    message = capsys.readouterr().err
    assert option[0] in message
    assert message.count("\n") == 1
    assert not out.exists()
