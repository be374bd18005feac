"""A weak loop is warned of and refused; the paper's is neither."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from stickslip import cosim
from stickslip.catalog.parameters import friction_law
from stickslip.evaluation.motions import VALIDATION
from stickslip.servo.axis import LOOP, Axis, Datasheet
from stickslip.servo.measurement import slope
from stickslip.servo.tuned_pi import with_inertia, with_velocity_filter
from stickslip.servo.velocity_loop import close_velocity_loop, design_velocity_loop
from stickslip.trial.guards import (
    Trial,
    _at_bounds,
    growth_rate,
    hunting,
    inspect,
    stribeck,
    tolerance,
)
from tests.kept import further

AXIS = Axis(5.557, 6.6135, 1e-4)
TABLE_2 = {"F_s": 8.999, "F_c": 5.999, "v_s": 5.5697e-4, "sigma_0": 3.9162e5, "sigma_1": 4.4248e3}
ERRORS = {"F_s": 0.06, "F_c": 0.0015, "v_s": 6e-6, "sigma_0": 320.0, "sigma_1": 2.3}
PAPER = design_velocity_loop(AXIS, LOOP)
FILTERED = with_inertia(with_velocity_filter(PAPER, Datasheet(), 6.0))


@pytest.fixture
def make_trial(fmus):
    def make(loop, command, **changes):
        duration = command.corners()[-1] + command.begin
        v_cmd = command.sample(np.arange(round(duration / loop.T_s) + 1) * loop.T_s)
        return Trial(fmus, loop, TABLE_2, {**TABLE_2, **changes}, v_cmd)

    return make


def errors(trial):
    """Return the RMS tracking error without and with the compensator [m/s]."""
    found = []
    for compensated in (False, True):
        with trial.runs(compensated=compensated) as run:
            found.append(run.error())
    return tuple(found)


def weak(K_p, K_i):
    return close_velocity_loop(AXIS, 5e-4, 5e-4, K_p, K_i)


def slow(v):
    return cosim.Trapezoid(height=v, slope=20 * v, plateau=2.0, begin=0.1)


@pytest.mark.parametrize("loop", [PAPER, FILTERED], ids=["paper", "filter"])
@pytest.mark.parametrize("command", [VALIDATION, slow(0.3e-3)], ids=["validation", "slow"])
def test_a_stiff_loop_is_neither_warned_of_nor_refused(make_trial, loop, command):
    trial = make_trial(loop, command)
    assert inspect(trial, ERRORS) == []
    without, compensated = errors(trial)
    assert compensated < 0.7 * without


@pytest.mark.slow
@pytest.mark.parametrize("v", [0.3e-3, *further(1e-3)])
def test_a_weak_loop_at_slow_speed_is_warned_of_with_exact_parameters(make_trial, v):
    """The paper's friction, K_p = 200 N s/m: feedforward multiplies the squared error."""
    trial = make_trial(weak(200.0, 2000.0), slow(v))
    without, compensated = errors(trial)
    assert compensated**2 > 3 * without**2
    found = {finding.guard: finding for finding in inspect(trial, ERRORS)}
    assert {"stribeck", "over-compensation"} <= set(found)
    for finding in found.values():
        assert "\n" not in finding.message
        assert "; expected " in finding.message
    assert "against a damping K_p + b of 206.6 N s/m" in found["stribeck"].message
    assert found["stribeck"].figure > 10 * found["stribeck"].limit


def test_the_same_weak_loop_is_not_warned_of_where_its_command_is_fast(make_trial):
    trial = make_trial(weak(200.0, 2000.0), VALIDATION)
    without, compensated = errors(trial)
    assert compensated < 0.2 * without
    assert stribeck(trial) == []


def test_a_trial_does_not_depend_on_the_size_of_the_drive(make_trial):
    """Masses, gains and forces a million times smaller: the same motion, as no converter rounds."""
    by = 1e-6
    paper = make_trial(PAPER, VALIDATION)
    axis = Axis(by * AXIS.m, by * AXIS.b, AXIS.tau_i)
    loop = close_velocity_loop(axis, PAPER.T_s, PAPER.tau_f, by * PAPER.K_p, by * PAPER.K_i)
    tiny = friction_law().share(TABLE_2, by)
    small = replace(paper, loop=loop, friction=tiny, compensator=tiny)
    assert errors(small) == pytest.approx(errors(paper), rel=0.02)


def test_a_share_is_of_the_force_alone(fmus):
    """At the same velocities every force of the LuGre FMU is that share of the whole."""
    v = 1e-3 * np.sin(np.linspace(0.0, 40.0, 4000)) ** 3
    system = cosim.System("share")
    system.add("compensator", fmus / "compensator.fmu", TABLE_2)
    system.expose("v", "compensator.v")
    with system.prepare(step=5e-4, stop=2.0 - 5e-4, record=["compensator.F_mean"]) as simulation:
        whole, part = (
            simulation.run(
                {f"compensator.{name}": value for name, value in friction.items()}, {"v": v}
            )["compensator.F_mean"]
            for friction in (TABLE_2, friction_law().share(TABLE_2, 0.7))
        )
    np.testing.assert_allclose(part, 0.7 * whole, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("v", [2e-4, 1e-3])
def test_growth_is_the_fastest_pole_of_the_linear_loop(make_trial, v):
    """Continuous time, motion, integral and bristle in one matrix; sampling changes little."""
    K_p, K_i = 200.0, 330.0
    p, g_slope = TABLE_2, float(slope(TABLE_2, v))
    tiny = 1e-9

    def g(speed):
        return p["F_c"] + (p["F_s"] - p["F_c"]) * np.exp(-speed / p["v_s"])

    assert g_slope == pytest.approx((g(v + tiny) - g(v - tiny)) / (2 * tiny), rel=1e-4)
    a, c = p["sigma_0"] * v / g(v), v * g_slope / g(v)
    A = np.array(
        [
            [-(AXIS.b + K_p + p["sigma_1"] * c), -K_i, -(p["sigma_0"] - p["sigma_1"] * a)],
            [1.0, 0.0, 0.0],
            [c, 0.0, -a],
        ]
    )
    A[0] /= AXIS.m
    expected = np.linalg.eigvals(A).real.max()
    found = growth_rate(make_trial(weak(K_p, K_i), VALIDATION), v)
    assert expected > 50.0
    assert found == pytest.approx(expected, rel=0.1)


def test_a_force_that_is_far_too_large_is_told(make_trial):
    assert tolerance(make_trial(PAPER, VALIDATION, F_c=9.0, F_s=13.5), {}) == []
    [finding] = tolerance(make_trial(PAPER, VALIDATION, F_c=10.2, F_s=15.3), {})
    assert finding.guard == "over-compensation"
    assert 0.0 < finding.figure < 0.2
    # 1.7 times the friction and that share more is where compensation stops to help
    for share, helps in ((finding.figure - 0.03, True), (finding.figure + 0.05, False)):
        factor = 1.7 * (1.0 + share)
        changes = {"F_c": factor * TABLE_2["F_c"], "F_s": factor * TABLE_2["F_s"]}
        without, compensated = errors(make_trial(PAPER, VALIDATION, **changes))
        assert (compensated < without) == helps


def test_a_parameter_that_may_be_anything_is_told(make_trial):
    trial = make_trial(PAPER, VALIDATION)
    [finding] = tolerance(trial, {**ERRORS, "sigma_0": 3e5})
    assert finding.guard == "uncertainty"
    assert "sigma_0 = 391.6, a bound of its 95 % interval" in finding.message
    assert finding.figure > finding.limit


def test_a_bound_is_two_standard_errors_away():
    """Of a normal distribution 95 % lie within 1.96 standard errors."""
    friction = {"F_s": 9.0, "F_c": 6.0}
    tried = []

    def error(compensator=friction):
        tried.append(compensator["F_s"])
        return 0.5

    run = SimpleNamespace(
        trial=SimpleNamespace(law=friction_law(), compensator=friction), error=error
    )
    _at_bounds(run, 1.0, {"F_s": 0.1})
    draws = np.random.default_rng(0).normal(9.0, 0.1, 100_000)
    assert np.mean((draws > min(tried)) & (draws < max(tried))) == pytest.approx(0.95, abs=0.003)


def test_stick_and_slip_is_told(make_trial):
    [finding] = hunting(make_trial(weak(1000.0, 5000.0), slow(0.3e-3)))
    assert "while 0.3 mm/s is commanded" in finding.message
    assert finding.figure > 1e-3
    assert hunting(make_trial(PAPER, slow(0.3e-3))) == []
