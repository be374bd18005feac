"""One recording of 20 s: what its loop tells, what its inverse model alone, and side by side."""

import json
import threading
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from scipy.signal import lfilter

from stickslip.catalog.parameters import UNITS
from stickslip.errors import IdentificationError, UsageError
from stickslip.identification.criteria import runs
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.known_loop import KnownLoop, OutputError, predictor_error
from stickslip.identification.criteria.runs import Runs
from stickslip.identification.estimation import LearnSettings, Task, learn
from stickslip.identification.fitting.bootstrap import correct
from stickslip.identification.fitting.fit import linearised
from stickslip.logs import load_description, read_recording
from stickslip.papers.lugre.record import RECORD_FILES, write_record_results
from stickslip.rigs.contract import commissioning_loop
from stickslip.servo.axis import Datasheet
from stickslip.servo.lanes import FEWEST
from stickslip.studies.learn.recorded import record_drive
from stickslip.thresholds import misfit
from stickslip.trial.compensator_trial import shown_gains

pytestmark = pytest.mark.slow

LIMITS = {"F_c": 0.005, "sigma_0": 0.05, "sigma_1": 0.05, "m": 0.005, "F_s": 0.05, "v_s": 0.1}


def test_the_known_loop_judges_and_finds_parameters_with_intervals(recorded):
    """Its residual is what encoder and noise explain."""
    assert recorded.learned.estimation.criterion == "output error"
    assert "controller is known" in recorded.learned.estimation.reason
    assert recorded.learned.estimation.model_error < 2.0
    table = recorded.table2().set_index("parameter")
    for name, limit in LIMITS.items():
        assert table.learned[name] == pytest.approx(table.drive[name], rel=limit), name
    assert ((table["low"] < table["learned"]) & (table["learned"] < table["high"])).all()
    # Factor 2 on the 95 % interval: a miss there would be one in ten thousand.
    middle, half = table["learned"], (table["high"] - table["low"])
    assert (np.abs(table["drive"] - middle) < half).all()


def test_tracking_errors_fall(recorded):
    """The measured ones keep the noise of this drive's encoder."""
    table = recorded.validation.table().set_index("velocity")
    assert (table.reduction["measured"] > 0.85).all()
    assert (table.reduction["true"] > 0.9).all()


def test_the_commissioning_loop_bears_a_third_and_three_times_its_mass(make_rig):
    for mass in (5.5 / 3.0, 5.5 * 3.0):
        recording = record_drive(make_rig(m=mass))
        assert np.abs(recording.force).max() < 100.0
        assert np.abs(np.gradient(recording.position, recording.T_s)).max() < 0.08


@pytest.mark.usefixtures("without_pictures")
def test_the_written_recording_is_the_recording(recorded, tmp_path):
    write_record_results(recorded, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {*RECORD_FILES, "manifest.json"}
    description = load_description(tmp_path / "recording.toml")
    reading = read_recording(tmp_path / "recording.csv", description)
    recording = recorded.learned.estimation.recording
    np.testing.assert_allclose(reading.recording.position, recording.position, atol=1e-15)
    np.testing.assert_allclose(reading.recording.force, recording.force, atol=1e-12)
    gains = reading.controller.parameters()
    assert gains["K_p"] == pytest.approx(commissioning_loop(Datasheet()).K_p)
    document = json.loads((tmp_path / "learned.json").read_text())
    assert set(document["parameters"]) == set(UNITS)
    for name, entry in document["parameters"].items():
        assert entry["low"] < entry["value"] < entry["high"], name
    assert (tmp_path / "report.html").exists()


@pytest.mark.parametrize("pole", [0.9, -0.5])
def test_the_whitening_of_an_autoregression_is_its_polynomial(pole):
    noise = np.random.default_rng(0).standard_normal(200_000)
    signal = lfilter([1.0], [1.0, -pole], noise)
    taps = predictor_error(signal, 5)
    np.testing.assert_allclose(taps, [1.0, -pole, 0, 0, 0, 0], atol=0.02)
    white = lfilter(taps, [1.0], signal)
    assert abs(np.corrcoef(white[1:], white[:-1])[0, 1]) < 0.01
    assert predictor_error(np.zeros(100), 5).tolist() == [1.0]


@pytest.mark.parametrize("off", [0.0, 0.2])
def test_a_bad_fit_does_not_pass_for_noise(off, recorded, candidates):
    """Replicas are given as much noise as the fit left, so they leave as much themselves."""
    learned = recorded.learned.estimation
    best = learned.fit
    q = best.q.copy()
    q[best.space.index("F_c")] += off
    with OutputError(candidates, learned.recording, learned.gains) as criterion:
        criterion.whiten(best.parameters)
        values = best.space.decode(q)
        variance = float(np.var(criterion.residual(values)))
        bad = linearised(criterion.over(best.space), q, variance)
        with KnownLoop(candidates, learned.recording, learned.gains, encoder=True) as again:
            told = correct(criterion, bad, again, 0)
    assert told.found / told.expected < misfit.EXPLAINED
    assert (told.model_error > misfit.EXPLAINED) == (off > 0.0)


def test_a_recording_shows_the_gains_of_its_controller(recorded):
    learned = recorded.learned.estimation
    K_p, K_i = shown_gains(learned.recording)
    assert K_p == pytest.approx(learned.gains["K_p"], rel=0.1)
    assert K_i == pytest.approx(learned.gains["K_i"], rel=0.1)
    noise = np.random.default_rng(0).normal(size=len(learned.recording.t))
    assert shown_gains(replace(learned.recording, force=noise)) is None
    assert shown_gains(replace(learned.recording, velocity_command=None)) is None


@pytest.fixture(params=["inverse model", "output error"])
def criterion_of(request, recorded, candidates):
    """Return a function that makes a criterion with so many workers."""
    learned = recorded.learned.estimation
    if request.param == "inverse model":
        return lambda workers: InverseModel(candidates, learned.recording, workers=workers)
    return lambda workers: OutputError(candidates, learned.recording, learned.gains, workers)


def test_as_many_run_at_once_as_there_are_workers(criterion_of, recorded, monkeypatch):
    values, met, run = recorded.learned.estimation.parameters, threading.Barrier(2), Runs.run

    def together(*arguments, **others):
        met.wait(timeout=60.0)  # broken if no other comes
        return run(*arguments, **others)

    monkeypatch.setattr(Runs, "run", together)
    points = [{**values, "F_c": k * values["F_c"]} for k in (0.9, 1.1)]
    assert len(points) < FEWEST
    with criterion_of(2) as criterion:
        criterion.map(points)


def test_what_runs_side_by_side_may_run_once_more(criterion_of, recorded):
    """A thread that waited for another one of the same few would wait for ever."""
    values = recorded.learned.estimation.parameters
    points = [{**values, "F_c": k * values["F_c"]} for k in (0.9, 1.0, 1.1)]
    with criterion_of(2) as criterion:
        runs = criterion.loop._logs[0].runs if hasattr(criterion, "loop") else criterion.runs
        found = runs.each(criterion.residual, points)
    assert len({one.tobytes() for one in found}) == len(points)


def test_a_slope_has_the_same_bits(criterion_of, recorded, monkeypatch):
    """Whatever the number of workers, and in lanes as by the FMUs."""
    best, found = recorded.learned.estimation.fit, []
    for workers, in_lanes in ((1, True), (3, True), (3, False)):
        if not in_lanes:
            monkeypatch.setattr(runs, "lanes_of", lambda _: None)
        with criterion_of(workers) as criterion:
            found.append(linearised(criterion.over(best.space), best.q, 1.0))
    for other in found[1:]:
        np.testing.assert_array_equal(other.jacobian, found[0].jacobian)
        np.testing.assert_array_equal(other.residual, found[0].residual)


@pytest.fixture(scope="module")
def told(recorded, candidates):
    recording = recorded.learned.estimation.recording.part(0, 20_000)
    return watched(candidates, replace(recording, velocity_command=None))


def watched(candidates, recording):
    """Learn; return with it the fit, what the stand-in makes of it, and whether that is alike."""
    module, seen = import_module("stickslip.identification.fitting.bootstrap"), []
    correct = module.correct_inverse

    def spy(inverse, found, *others):
        seen.append((found, *correct(inverse, found, *others)))
        return seen[-1][1:]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "correct_inverse", spy)
        return learn(Task(candidates, recording)), seen[-1]


@pytest.mark.thorough
def test_the_inverse_model_finds_what_shows_well_and_is_less_sure_than_the_loop(told, recorded):
    alone, _ = told
    assert alone.criterion == "inverse model"
    assert "not known" in alone.reason
    for name, limit in {"m": 0.01, "F_c": 0.01, "sigma_0": 0.03, "sigma_1": 0.03}.items():
        assert alone.parameters[name] == pytest.approx(recorded.truth[name], rel=limit)
    for name, known in alone.known.items():
        assert known.standard_error > recorded.learned.estimation.known[name].standard_error


@pytest.mark.thorough
def test_a_constant_force_changes_nothing_else(told, candidates):
    """As on a vertical axis, whose controller bears the load when the log begins."""
    alone, _ = told
    lifted = replace(alone.recording, force=alone.recording.force + 40.0)
    learned = learn(Task(candidates, lifted))
    assert abs(learned.parameters["F_0"] - alone.parameters["F_0"] - 40.0) < 0.02
    for name in alone.known:
        apart = learned.parameters[name] - alone.parameters[name]
        assert abs(apart) < 0.2 * alone.errors[name], name


def test_a_force_of_the_wrong_sign_and_missing_gains_are_told(recorded, candidates):
    recording = recorded.learned.estimation.recording
    turned = replace(recording, force=-np.asarray(recording.force))
    with pytest.raises(IdentificationError, match="signs"):
        learn(Task(candidates, turned))
    loop = LearnSettings(law="lugre", criterion="loop")
    with pytest.raises(UsageError, match="needs the controller"):
        learn(Task(candidates, recording, settings=loop))


@pytest.mark.thorough
def test_a_stand_in_that_shakes_the_drive_otherwise_is_not_believed(told, candidates):
    """What no replica shows, here noise on the logged force, is none of the encoder's doing."""
    quiet = told[0].recording
    noise = np.random.default_rng(0).normal(0.0, 1.0, len(quiet.t))
    shaken = watched(candidates, replace(quiet, force=quiet.force + noise))
    for (learned, (found, corrected, bias, alike)), believed in ((told, True), (shaken, False)):
        assert alike == believed
        assert bias.any()
        assert learned.fit.parameters == (corrected if alike else found).parameters
        assert learned.errors["sigma_0"] > found.errors()["sigma_0"]  # the motion tells F_c
