"""The loop of a log, simulated: against the trial's system of FMUs, and the linear loop."""

from dataclasses import replace

import control
import numpy as np
import pytest

from stickslip.catalog.parameters import PAPER, friction_law
from stickslip.cosim import Trapezoid
from stickslip.errors import UsageError
from stickslip.evaluation.tracking import (
    FEEDFORWARD,
    FRICTIONLESS,
    NONE,
    LearnedDrive,
    commanded_position,
    commanded_velocity,
    simulate,
)
from stickslip.identification.estimation import candidate_fmus
from stickslip.logs import Recording
from stickslip.servo.axis import LOOP, Axis, Datasheet
from stickslip.servo.systems import Compensator, build_fmus, paper_loop
from stickslip.trial.family import axis_values, in_loop

AXIS = Axis(5.557, 6.6135, 1e-4)
VALUES = {**PAPER, "m": AXIS.m, "b": AXIS.b, "F_0": 0.0, "delay": AXIS.tau_i, "delta": 1.0}
FRICTION = {name: VALUES[name] for name in friction_law().parameters if name in VALUES}
COMPENSATOR = Compensator("compensator", "compensator", FRICTION)
T = np.arange(4001) * LOOP.T_s
COMMAND = Trapezoid(0.04, 0.4, 0.3, 0.1).sample(T)
STEP = 1e-9
COMMANDED = Recording(T, np.zeros_like(T), velocity_command=COMMAND, encoder_step=STEP)


def gains_of(loop):
    return {name: getattr(loop, name) for name in ("K_p", "K_i", "tau_f", "T_s")}


@pytest.fixture(scope="module")
def runs(loop):
    with candidate_fmus() as fmus:
        drive = LearnedDrive("lugre", VALUES, COMPENSATOR, loop)
        return simulate(fmus, COMMANDED, gains_of(loop), drive)


@pytest.mark.parametrize("compensated", [False, True])
def test_it_moves_like_the_paper_s_loop_of_fmus(loop, runs, compensated, tmp_path):
    build_fmus(tmp_path, {})
    sheet = Datasheet(peak_force=1e9, encoder_step=STEP)
    system = paper_loop(tmp_path, loop, FRICTION if compensated else None)
    system.parameters |= in_loop({**FRICTION, **axis_values(loop, sheet)})
    with system.prepare(step=LOOP.T_s, stop=T[-1], record=("drive.v",)) as simulation:
        velocity = simulation.run(inputs=loop.commands(COMMAND))["drive.v"]
    found = runs[FEEDFORWARD if compensated else NONE].velocity
    error = np.sqrt(np.mean((velocity - COMMAND) ** 2))
    assert np.sqrt(np.mean((found - velocity) ** 2)) < 0.02 * error


def test_without_friction_it_is_the_linear_loop(loop, runs):
    linear = control.forced_response(loop.nominal, inputs=COMMAND).outputs
    np.testing.assert_allclose(runs[FRICTIONLESS].velocity, linear, atol=2e-6)


def test_a_cascade_is_simulated_with_its_position_loop():
    """A drive in a cascade comes back to the position command, one in a velocity loop does not."""
    position = np.cumsum(COMMAND) * LOOP.T_s
    recording = Recording(T, np.zeros_like(T), position_command=position, encoder_step=STEP)
    with candidate_fmus() as fmus:
        drive = LearnedDrive("lugre", VALUES, COMPENSATOR)
        cascade = {"K_x": 30.0, "K_p": 3000.0, "K_i": 0.0}
        runs = simulate(fmus, recording, cascade, drive)
    late = np.abs(runs[NONE].position - position)[-1]
    assert 0.0 < late < 1.5 * FRICTION["F_s"] / (30.0 * 3000.0)
    errors = {name: np.std(run.velocity - COMMAND) for name, run in runs.items()}
    assert errors[FEEDFORWARD] < errors[NONE]


def test_the_command_of_velocity_is_the_derivative_of_that_of_position():
    position = 0.01 * np.sin(2.0 * T)
    recording = Recording(T, np.zeros_like(T), position_command=position)
    middle = slice(200, -200)
    expected = 0.02 * np.cos(2.0 * T)
    np.testing.assert_allclose(commanded_velocity(recording)[middle], expected[middle], atol=1e-6)
    assert commanded_position(recording) is position
    with pytest.raises(UsageError, match="no command; log the velocity or position command"):
        commanded_velocity(Recording(T, position))


def test_a_force_of_position_acts_without_a_compensator_and_is_cancelled_with_it(loop, runs):
    known = 4.0 * np.sin(2.0 * np.pi * np.cumsum(COMMAND) * LOOP.T_s / 0.004)
    held = replace(COMMANDED, known_force=known)
    with candidate_fmus() as fmus:
        drive = LearnedDrive("lugre", VALUES, COMPENSATOR, loop)
        found = simulate(fmus, held, gains_of(loop), drive)
    for name in (FEEDFORWARD, FRICTIONLESS):
        np.testing.assert_allclose(found[name].velocity, runs[name].velocity, atol=1e-9)
    assert np.std(found[NONE].velocity - runs[NONE].velocity) > 1e-4
