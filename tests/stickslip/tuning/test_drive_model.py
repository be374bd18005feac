"""Models that err in a loop as the drive does: what is found of it, and which laws are tried."""

from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace
from unittest.mock import patch

import numpy as np
import pytest

from stickslip import ga
from stickslip.catalog.parameters import LUGRE, PAPER
from stickslip.papers.lugre.loop_tuning import with_friction
from stickslip.papers.lugre.reproduction import drive_truth
from stickslip.servo.tuned_pi import tuned_pi
from stickslip.thresholds import kept
from stickslip.tuning import drive_model
from stickslip.tuning.drive_model import fit_models
from stickslip.tuning.loop_runs import PLAIN, LoopBench, LoopRuns
from tests.kept import further

pytestmark = pytest.mark.slow

SOFT = PLAIN | {"K_p": 0.6, "K_i": 0.4, "m_ff": 0.8, "share": 0.9, "observed": 0.2}
"""Not one of the loops that the drive runs."""


@pytest.fixture
def bench_of(loop, make_rig):
    def bench(friction=None, **drive):
        own = {name: PAPER[name] for name in LUGRE} | (friction or {})
        return LoopBench(make_rig(**drive), tuned_pi(loop), own)

    return bench


def errors_with(bench, law, values):
    """Return the errors of the true velocity with a model of the drive."""
    runs = LoopRuns(bench, law, tuple(values))
    v = runs.run(bench.loop(SOFT), values)[f"{runs.drive}.v"]
    runs.close()
    return np.array(list(runs.errors(v).values()))


def unlike(found, true):
    return float(np.sqrt(np.mean(np.log(found / true) ** 2)))


def test_what_was_identified_is_taken_where_it_errs_like_the_drive(bench_of):
    (model,) = fit_models(bench_of())
    assert not model.fitted
    assert model.law == "lugre"
    assert model.mismatch < 0.5 * kept.ERRS_ALIKE


@pytest.mark.thorough
@pytest.mark.parametrize("noise", [1.5e-7, *further(1e-7)])
def test_the_noise_of_the_encoder_is_found_from_the_errors_it_makes(bench_of, noise):
    (model,) = fit_models(bench_of(noise=1.0, noise_x=noise))
    assert not model.fitted
    assert model.noise == pytest.approx(noise, rel=0.2)
    assert model.mismatch < 0.5 * kept.ERRS_ALIKE


@pytest.mark.thorough
def test_a_drive_of_another_law_has_a_model_that_errs_like_it_with_other_friction(
    bench_of, monkeypatch
):
    monkeypatch.setattr(drive_model, "LAWS", ("lugre", "dahl", "coulomb_stribeck"))
    bench = bench_of(law="coulomb_stribeck")
    best = fit_models(bench)[0]
    assert best.law == "coulomb_stribeck"
    truth = drive_truth({"law": "coulomb_stribeck"})
    for level in (0.7, 1.3):
        own = {"m": truth["m"], "b": truth["b"]} | with_friction(best.law, truth, level)
        true = errors_with(bench, best.law, own)
        found = errors_with(bench, best.law, best.parameters(bench, level))
        lugre = drive_model.start_model(bench, "lugre").parameters(bench, level)
        assert unlike(found, true) < 0.1
        assert unlike(errors_with(bench, "lugre", lugre), true) > 0.3


def models(starts, ends=(), own="lugre", default=9.0):
    """Return the laws of models, and the evaluations of those searched, by mismatches of stubs.

    ``starts`` and ``ends`` are mismatches before and after a search, and ``own`` is the law of the
    rig.
    """
    searched = {}

    class Search:
        def __init__(self, law):
            self.model = SimpleNamespace(law=law, mismatch=starts.get(law, default))

        def to(self, evaluations, *_):
            searched[self.model.law] = evaluations
            self.model.mismatch = dict(ends).get(self.model.law, self.model.mismatch)

    with patch.multiple(
        drive_model,
        LoopRuns=lambda _: SimpleNamespace(close=list),
        errors_of=lambda _: None,
        Mismatch=lambda _, law, __: nullcontext(law),
        LawSearch=Search,
    ):
        rig = SimpleNamespace(law=SimpleNamespace(name=own))
        found = fit_models(SimpleNamespace(rig=rig))
    return [one.law for one in found], searched


def test_laws_are_tried_until_two_are_left_and_those_as_good_are_used(monkeypatch):
    starts = dict.fromkeys(drive_model.LAWS, 0.5) | {"gms": 0.3, "armstrong": 0.7}
    ends = dict.fromkeys(drive_model.LAWS, 0.4) | {"gms": 0.2, "dahl": 0.25}
    few, many = drive_model.ROUNDS
    searched = dict.fromkeys({*drive_model.LAWS} - {"armstrong"}, few)
    assert models(starts, ends) == (["gms", "dahl"], searched | {"gms": many, "dahl": many})
    monkeypatch.setattr(drive_model, "FINALISTS", 1)
    assert models(starts, ends)[0] == ["gms"]


def test_a_law_that_takes_long_to_run_is_no_model():
    assert models({"lugre": 0.02, "leuven": 0.01}, own="leuven")[0] == ["lugre"]


def test_a_model_that_was_not_fitted_has_a_steeper_curve_with_more_friction(bench_of):
    bench = bench_of()
    start = drive_model.start_model(bench, "lugre")
    deltas = [start.parameters(bench, level)["delta"] for level in (0.7, 1.0, 1.3)]
    assert deltas == [1.0, 1.0, drive_model.STEEPER]
    fitted = replace(start, fitted=True).parameters(bench, 1.3)
    assert fitted["delta"] == 1.0
    assert fitted["F_c"] == pytest.approx(1.3 * PAPER["F_c"])


def test_a_law_that_cannot_run_is_no_model(bench_of, monkeypatch):
    def of(_, model):
        if model.law == "dahl":
            raise ga.CandidateFailed("its FMU ended")
        return 0.01 if model.law == "gms" else 0.015

    monkeypatch.setattr(kept, "ERRS_ALIKE", 0.0)
    monkeypatch.setattr(drive_model, "LAWS", ("dahl", "gms", "lugre"))
    monkeypatch.setattr(drive_model.Mismatch, "of", of)
    assert [model.law for model in fit_models(bench_of())] == ["gms"]
