"""A disturbance observer beside a feedforward, tried on simulated drives."""

from dataclasses import replace

import pytest

from stickslip.catalog.parameters import friction_law
from stickslip.evaluation.motions import VALIDATION
from stickslip.servo.axis import Axis, Datasheet
from stickslip.servo.velocity_loop import LoopSpecification, design_velocity_loop
from stickslip.studies.learn import tables
from stickslip.thresholds import offer
from stickslip.trial.guards import Evidence, bench_of, family, feedforward
from stickslip.trial.observed import BOTH, OBSERVER, ObserverTrial, kalman_designs, try_observer

AXIS = Axis(80.0, 100.0, 1e-3)
FRICTION = {"F_s": 80.0, "F_c": 60.0, "v_s": 1e-3, "sigma_0": 4e6, "sigma_1": 8e3, "delta": 1.0}
DAHL = {"F_c": 60.0, "sigma_0": 4e6}
LAW = friction_law()


@pytest.fixture(scope="module")
def observed() -> ObserverTrial:
    """Return what an observer does on a heavy axis, whose feedforward harms at half friction."""
    loop = design_velocity_loop(AXIS, LoopSpecification(30.0, 55.0, 5e-4, 1e-3))
    command = replace(VALIDATION, height=0.2, slope=5 * VALIDATION.slope)
    sheet = Datasheet(peak_force=1e4, tau_i=AXIS.tau_i, encoder_step=1e-7)
    drives = [
        drive
        for drive in family(LAW, FRICTION, command, Evidence(rivals={"dahl": DAHL}))
        if drive.name in ("friction as fitted", "friction x 0.5", "Dahl friction")
    ]
    assert len(drives) == 3
    with bench_of(LAW, loop, FRICTION, drives, command, sheet) as bench:
        (whole,) = bench.benefits([feedforward(FRICTION)], shares=(1.0,))
        return try_observer(bench, whole, kalman_designs(bench, FRICTION["F_c"], (0.9, 1.0, 1.2)))


def test_an_observer_takes_the_place_of_a_feedforward_that_harms_and_both_are_better(observed):
    assert not observed.feedforward.acceptable
    assert observed.recommended == OBSERVER
    assert observed.alone.acceptable
    assert observed.alone.mean_ratio < 0.6
    assert observed.refusal(OBSERVER) == ""
    assert observed.designed.sensitivity <= offer.SENSITIVITY
    parts = tables.parts(observed).frame().set_index("part")
    assert parts["mean"][BOTH] < parts["mean"]["feedforward"]
    assert parts["worst"][BOTH] < parts["worst"]["feedforward"]
    assert not parts["acceptable"]["feedforward"]


def test_a_part_that_harms_is_not_recommended(observed):
    worse = replace(observed.alone, rows=observed.feedforward.rows)
    assert replace(observed, alone=worse).recommended == ""
    good = replace(observed.alone, rows=observed.alone.rows)
    acceptable = replace(observed.feedforward, rows=good.rows)
    both = replace(observed, feedforward=acceptable, both=worse)
    assert both.recommended == "feedforward"
    assert "with feedforward + observer" not in both.refusal(OBSERVER)
    assert "times that without" in both.refusal(BOTH)
