"""Logs that mislead: the fault is named with its figure, and nothing is called identifiable."""

from dataclasses import replace

import pytest
from drives import GAINS, run

from stickslip.identification.estimation import Task, learn
from stickslip.logs import Finding, Recording
from stickslip.planning import Limits, plan

pytestmark = pytest.mark.slow

LOST = Finding("warning", "rows are lost", "2 %", spoils="values")


@pytest.fixture(scope="module")
def short():
    command = plan(Limits(duration=8.0))["velocity_command"].to_numpy()
    log = run("lugre", command, uneven=0.0)
    signals = {"force": log["applied"], "velocity_command": log["v_cmd"]}
    return Recording(log["t"], log["position"], **signals, encoder_step=4e-7, source="elsewhere")


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
