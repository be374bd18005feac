"""A controller is recognised as others sample it, and with what is added to output or command."""

from dataclasses import replace
from unittest.mock import patch

import numpy as np
import pytest
from scipy.signal import lfilter

from stickslip.identification.criteria.controller_check import (
    check_controller,
    force_noise,
    in_time,
    with_force,
)
from stickslip.identification.criteria.known_loop import KnownLoop, fmu_gains
from stickslip.identification.estimation import LearnSettings
from stickslip.logs import Controller, Finding, Reading, Recording, check_recording, samples_late
from stickslip.logs.channels import Channel
from stickslip.logs.checks import REMOVED
from stickslip.logs.plausibility import DIFFER
from stickslip.logs.units import unit_named
from stickslip.studies.learn import learned
from stickslip.studies.learn.controller_findings import check_description
from stickslip.thresholds import control_match
from tests.stickslip.identification import drives

T_S = 5e-4
GAINS = {"K_p": 300.0, "K_i": 9000.0, "P_x": 4000.0, "I_x": 50000.0, "tau_f": 3e-3, "T_s": T_S}
WEIGHTS = {
    "": 1.0 - np.exp(-T_S / GAINS["tau_f"]),
    "low-pass by backward Euler": T_S / (T_S + GAINS["tau_f"]),
    "low-pass by forward Euler": T_S / GAINS["tau_f"],
}
SHARES = {"": 1.0, "integral by the trapezoidal rule": 0.5, "integral by forward Euler": 0.0}


@pytest.fixture(scope="module")
def motion():
    """Position, and commands that it does not follow well."""
    t = T_S * np.arange(6000)
    rng = np.random.default_rng(3)
    x = 0.01 * np.sin(7.0 * t) + np.cumsum(rng.normal(0.0, 2e-6, len(t)))
    return t, x - x[0], 0.07 * np.cos(7.0 * t) + 0.02, 0.01 * np.sin(6.8 * t)


def commanded(motion, share, weight, v=0.0, integral=0.0, u_max=np.inf):
    """Difference equations of a PI of velocity beside one of position.

    Where the force is limited, the integral does not grow towards the limit.
    """
    t, x, v_cmd, x_cmd = motion
    force, last = np.empty(len(t)), x[0]
    for k in range(len(t)):
        v += weight * ((x[k] - last) / T_S - v)
        last = x[k]
        e_v, e_x = v_cmd[k] - v, x_cmd[k] - x[k]
        new = integral + T_S * (GAINS["K_i"] * e_v + GAINS["I_x"] * e_x)
        force[k] = GAINS["K_p"] * e_v + GAINS["P_x"] * e_x
        force[k] += share * new + (1.0 - share) * integral
        if abs(force[k]) > u_max:
            force[k] = np.clip(force[k], -u_max, u_max)
            new = integral if (new - integral) * force[k] > 0.0 else new
        integral = new
    return force


def checked(candidates, motion, force):
    t, x, v_cmd, x_cmd = motion
    recording = Recording(t, x, force, velocity_command=v_cmd, position_command=x_cmd)
    return check_controller(candidates, recording, GAINS)


@pytest.mark.parametrize("low_pass", WEIGHTS)
@pytest.mark.parametrize("integral", SHARES)
def test_the_form_is_found(candidates, motion, integral, low_pass):
    force = commanded(motion, SHARES[integral], WEIGHTS[low_pass])
    check = checked(candidates, motion, force)
    assert check.form == ", ".join(filter(None, (integral, low_pass)))
    assert check.error < 1e-9
    last = slice(-1)  # is held, not computed
    np.testing.assert_allclose(check.force[last], force[last], atol=1e-9 * np.abs(force).max())


@pytest.mark.parametrize("lag", [1.0, 0.7])
@pytest.mark.parametrize("noise", [0.0, 0.03, 0.3])
def test_noise_of_the_force_is_told_from_the_controller(candidates, motion, noise, lag):
    """Also where the current lags. A wrong controller shows no noise."""
    sent = commanded(motion, 1.0, WEIGHTS[""])
    late = lag * np.concatenate([sent[:1], sent[:-1]]) + (1.0 - lag) * sent
    measured = late + np.random.default_rng(5).normal(0.0, noise, len(sent))
    check = checked(candidates, motion, measured)
    assert check.shift == 1
    assert check.error < control_match.EXACT
    assert force_noise(measured, check) == pytest.approx(noise, rel=0.05, abs=1e-8)
    two = replace(check, force=np.concatenate([check.force, 500.0 + check.force]))
    joined = np.concatenate([measured, 500.0 + measured])
    assert force_noise(joined, two) == pytest.approx(noise, rel=0.05, abs=1e-6)
    assert force_noise(1.1 * measured, checked(candidates, motion, 1.1 * measured)) == 0.0
    assert force_noise(measured, None) == 0.0


@pytest.mark.parametrize("shift", [0, 2])
def test_what_the_controller_remembers_is_found(candidates, motion, shift):
    force = commanded(motion, 1.0, WEIGHTS[""], v=0.3, integral=70.0)
    logged = np.append(np.full(shift, force[0]), force[: len(force) - shift])
    check = checked(candidates, motion, logged)
    assert (check.shift, check.form) == (shift, "")
    assert check.error < 1e-9
    np.testing.assert_allclose(check.force[:-1], force[:-1], atol=1e-9 * np.abs(force).max())


@pytest.mark.parametrize("late", [0.5, -0.5])
def test_a_position_command_that_is_another_sum_of_the_velocity_command_is_found(
    candidates, motion, late
):
    """The controller adds a velocity command up before or after its use; the log has the mean."""
    t, x, *_ = motion
    v_cmd = 0.07 * np.cos(7.0 * t)  # of the motion but for its noise
    gains = {"K_p": 300.0, "K_i": 9000.0, "K_x": 25.0, "tau_f": 3e-3, "T_s": T_S}
    x_cmd = np.append(0.0, np.cumsum(0.5 * T_S * (v_cmd[1:] + v_cmd[:-1])))
    own = x_cmd - late * T_S * v_cmd
    v = lfilter([WEIGHTS[""]], [1.0, WEIGHTS[""] - 1.0], np.diff(x, prepend=x[0]) / T_S)
    e = gains["K_x"] * (own - x) + v_cmd - v
    force = gains["K_p"] * e + gains["K_i"] * T_S * np.cumsum(e)
    recording = Recording(t, x, force, velocity_command=v_cmd, position_command=x_cmd)
    check = check_controller(candidates, recording, gains)
    way = "later" if late > 0.0 else "earlier"
    assert check.form == f"position command half a sample {way} than the log's"
    assert check.error < 1e-9
    assert check_controller(candidates, recording, {**gains, "K_x": 30.0}).error > 0.01


@pytest.mark.parametrize("noise", [0.0, 0.3])
def test_a_limit_that_is_not_given_is_found(candidates, motion, noise):
    whole = commanded(motion, 1.0, WEIGHTS[""])
    limit = float(np.quantile(np.abs(whole), 0.85))
    force = commanded(motion, 1.0, WEIGHTS[""], u_max=limit)
    logged = force + np.random.default_rng(5).normal(0.0, noise, len(force))
    check = checked(candidates, motion, logged)
    assert check.form == "limit of the force as the log shows it"
    assert check.gains["u_max"] == pytest.approx(limit, rel=max(1e-9, 2.0 * noise / limit))
    assert check.error < 0.01


T = np.arange(6000) * drives.T_S
COMMAND = 0.01 * np.sin(2 * np.pi * 1.3 * T)
SOFT = {
    "m": 0.7012, "b": 7.947, "F_s": 1.1063, "F_c": 0.7856, "v_s": 2.54e-3, "sigma_0": 2079.0,
    "sigma_1": 64.2, "encoder": 4.29e-6, "K_p": 124.19, "K_i": 5148.0, "tau_f": 1.357e-3,
}  # fmt: skip
"""A drive that bends for 0.4 mm before it slides, and its controller."""


PI = {name: drives.GAINS[name] for name in ("K_p", "K_i", "tau_f")}


@pytest.fixture(scope="module")
def stage():
    return drives.recording("lugre", COMMAND)


def test_a_force_that_the_controller_commands_is_not_shifted():
    v_cmd = 0.05 * np.sin(2.0 * np.pi * 4.0 * T)
    soft = drives.recording("lugre", v_cmd, noise=0.013, **SOFT)
    assert samples_late(soft) < -2  # for a rigid drive
    log = Reading(soft, Controller("PI", **{n: SOFT[n] for n in ("K_p", "K_i", "tau_f")}))
    findings = check_recording(soft)
    assert any(one.advice.endswith(REMOVED) for one in findings)
    prompt, left = in_time(log, findings)
    assert prompt is log
    assert not any(one.advice.endswith(REMOVED) for one in left)
    unknown, same = in_time(replace(log, controller=Controller()), findings)
    assert len(unknown.recording.t) == len(T) + samples_late(soft)
    assert same == findings


@pytest.mark.parametrize("scale", [1.0, 2.0])
def test_commands_of_another_scale_are_those_with_which_the_force_is_not_commanded(stage, scale):
    log = replace(stage, velocity_command=scale * COMMAND)
    doubt = Finding("warning", f"d(position)/dt and velocity_command {DIFFER}", spoils="values")
    _, left = in_time(Reading(log, Controller("PI", **PI)), [doubt])
    assert left == (() if scale == 1.0 else (doubt,))


def test_a_force_that_is_logged_late_is_shifted(stage):
    late = replace(stage, force=np.append(np.full(3, stage.force[0]), stage.force[:-3]))
    shifted, _ = in_time(Reading(late, Controller("PI", **PI)), ())
    assert samples_late(late) > 2
    np.testing.assert_array_equal(shifted.recording.force, late.force[samples_late(late) :])


def test_a_force_that_was_not_logged_is_what_the_controller_commands(stage):
    assert with_force(stage, PI) is stage
    silent = replace(stage, force=None)
    assert with_force(silent, None) is silent
    force = with_force(silent, PI).force
    assert np.sqrt(np.mean((force - stage.force) ** 2)) < 0.01 * np.ptp(stage.force)
    with (
        patch.object(learned, "predictions", side_effect=InterruptedError) as compared,
        pytest.raises(InterruptedError),
    ):
        learned.learn_recording(silent, PI, None, (), LearnSettings())
    np.testing.assert_array_equal(compared.call_args.args[0].force, force)


@pytest.mark.parametrize(("factor", "advice"), [(1e3, 'unit="mN"'), (3.0, "scale=0.3333")])
def test_a_force_out_of_scale_with_its_command_names_what_corrects_it(stage, factor, advice):
    log = replace(stage, force=factor * stage.force)
    channel = Channel("force", "force", unit_named("N"))
    reading = Reading(log, Controller("PI", **PI), channels=(channel,))
    [found] = check_description(reading, ())
    assert f'("force": Column({advice})' in found.advice.replace("{", "(")


def test_another_controller_is_told_by_the_gains_given(candidates, motion):
    """What no form explains is not explained away: the gains stay as they were given."""
    check = checked(candidates, motion, 1.3 * commanded(motion, 1.0, WEIGHTS[""]))
    assert fmu_gains(check.gains) == GAINS
    assert check.error > 0.1


DITHER = 4.0 * np.sign(np.sin(2 * np.pi * 23.0 * T))
PULSES = 0.004 * (np.sin(2 * np.pi * 3.1 * T) > 0.8)
VALUES = {
    name: drives.STAGE[name] for name in ("m", "b", "F_s", "F_c", "v_s", "sigma_0", "sigma_1")
}


@pytest.fixture(scope="module", params=["force", "velocity"])
def log(request):
    """Return a recording of an independent drive with an added signal, and without its role."""
    added = {f"added_{request.param}": DITHER if request.param == "force" else PULSES}
    v_cmd = COMMAND + added.get("added_velocity", 0.0)
    found = drives.recording("lugre", v_cmd, feedforward=added.get("added_force"), encoder=1e-9)
    plain = replace(found, velocity_command=COMMAND)
    return replace(plain, **added), plain


def test_the_controller_with_what_was_added_commands_the_force(log, candidates):
    known, plain = (check_controller(candidates, one, drives.GAINS).error for one in log)
    assert known < 1e-3
    assert plain > 10 * known


def test_the_loop_follows_what_was_added(log, candidates):
    errors = []
    for one in log:
        with KnownLoop(candidates, one, drives.GAINS) as loop:
            position = loop.run({**VALUES, "F_0": 0.0, "delay": 1e-7})["candidate.x_enc"]
        errors.append(np.std(position - one.position) / np.std(one.position))
    known, plain = errors
    assert known < 2e-3
    assert plain > 10 * known
