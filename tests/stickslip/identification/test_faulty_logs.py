"""Logs that mislead: the fault is named with its figure, and nothing is called identifiable."""

from dataclasses import replace

import numpy as np
import pytest
from drives import GAINS, run

from stickslip.identification.estimation import Task, learn
from stickslip.logs import Finding, Recording, aligned, check_recording, samples_late
from stickslip.planning import Limits, plan
from tests.kept import further

pytestmark = pytest.mark.slow

LOST = Finding("warning", "rows are lost", "2 %", spoils="values")


def recording(recorded, force=None, rows=slice(None)):
    force = recorded["applied"] if force is None else force
    return Recording(
        recorded["t"][: len(recorded["t"][rows])],
        recorded["position"][rows],
        force=force[rows],
        velocity_command=recorded["v_cmd"][rows],
        encoder_step=4e-7,
        source="elsewhere",
    )


@pytest.fixture(scope="module")
def command():
    return plan()["velocity_command"].to_numpy()


@pytest.fixture(scope="module", params=["gms", *further("lugre")])
def drive(request, command):
    return request.param, run(request.param, command)


def unreliable(log):
    return [str(finding) for finding in check_recording(log) if finding.spoils]


@pytest.fixture(scope="module")
def limited(drive, command):
    """Return a run whose force is at its limit for about an eighth of the time."""
    runs = (run(drive[0], command, u_max=u_max) for u_max in np.arange(7.0, 20.0, 0.4))
    at_limit = ((one, np.abs(one["applied"])) for one in runs)
    return next(one for one, force in at_limit if np.mean(force >= force.max()) < 0.125)


def test_a_sound_log_has_no_fault(drive):
    log = recording(drive[1])
    assert unreliable(log) == []
    assert samples_late(log) == 0
    assert aligned(log, 0) is log


@pytest.mark.parametrize("samples", [10, -10, 40])
def test_a_delay_is_taken_out(drive, samples):
    log = recording(drive[1], np.roll(drive[1]["applied"], samples))
    late = samples_late(log)
    assert abs(late - samples) <= 1  # a sampled loop has half a sample of its own
    [said] = [str(finding) for finding in check_recording(log) if "removed" in finding.advice]
    assert said.startswith("warning: force is ")
    assert f"{0.5 * late:.4g} ms are removed" in said
    again = aligned(log, late)
    assert samples_late(again) == 0
    assert len(again.t) == len(log.t) - abs(late)
    k = 1000 + max(-late, 0)
    assert again.position[1000] == log.position[k]
    assert again.force[1000] == log.force[k + late]


@pytest.mark.parametrize("share", [0.005, 0.02, 0.1])
def test_lost_rows_are_counted(drive, share):
    n = len(drive[1]["t"])
    rows = np.flatnonzero(np.random.default_rng(1).random(n) >= share)
    [said] = unreliable(recording(drive[1], rows=rows))
    assert "rows are lost under an even clock" in said
    told = float(said.split(": ")[2].split("%")[0]) / 100.0
    assert told == pytest.approx(share, rel=0.2)


def test_a_limit_is_found_in_a_log_of_the_force_before_it_and_behind_it(limited):
    most = np.abs(limited["applied"]).max()
    [said] = unreliable(recording(limited, limited["commanded"]))
    assert "the force was logged before a limit" in said
    assert float(said.split("at most ")[1].split(";")[0]) == pytest.approx(most, rel=0.25)
    [said] = unreliable(recording(limited))
    assert f"force saturates at {most:.4g}: " in said


@pytest.fixture(scope="module")
def short():
    command = plan(Limits(duration=8.0))["velocity_command"].to_numpy()
    return recording(run("lugre", command, uneven=0.0))


def test_a_force_out_of_scale_names_the_factor(short, candidates):
    scaled = replace(short, force=0.3 * short.force)
    learned = learn(Task(candidates, scaled, GAINS, faults=(LOST,)))
    assert learned.controller.error == pytest.approx(1.0 / 0.3 - 1.0, rel=0.02)
    lost, fault = learned.faults
    assert lost == LOST
    assert fault.figure == "0.3 times as large"
    assert "Column(scale=3.33)" in fault.advice
    assert fault.spoils == "values"
    assert "identifiable" not in {known.identifiability for known in learned.known.values()}
    assert "weakly identifiable at best" in learned.known["F_c"].sentence


def test_rejected_gains_change_nothing(short, candidates):
    """They once kept the correction of the encoder's bias from being made."""
    without = learn(Task(candidates, short))
    rejected = learn(Task(candidates, short, {**GAINS, "K_i": 2.0 * GAINS["K_i"]}))
    assert rejected.controller.error > 0.01
    assert rejected.faults == without.faults == ()
    assert rejected.known == without.known
    assert rejected.parameters == without.parameters
    assert without.known["F_c"].identifiability == "identifiable"
