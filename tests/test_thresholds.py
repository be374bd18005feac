"""What changes when a threshold is doubled or halved, for each of them."""

import re
import sys
from contextlib import nullcontext, suppress
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

import numpy as np
import pandas as pd
import pytest
import scipy.signal

from stickslip import cosim, ga, thresholds
from stickslip.catalog.parameters import ParameterSpace, friction_law
from stickslip.errors import IdentificationError, RecordingError, RigError, UsageError
from stickslip.identification import estimation, held_out
from stickslip.identification.criteria import controller_check, inverse_model
from stickslip.identification.criteria.controller_check import ControllerCheck
from stickslip.identification.criteria.runs import Diverged, candidate_fmus, require_bounded
from stickslip.identification.estimation import LearnSettings, agreement
from stickslip.identification.estimation import task as estimation_task
from stickslip.identification.fitting import bootstrap, identifiability, search, start
from stickslip.identification.fitting.identifiability import (
    LEVELS,
    NOT_IDENTIFIABLE,
    Identifiability,
    conservative,
)
from stickslip.identification.fitting.start import Start
from stickslip.identification.selection import choice, prediction
from stickslip.identification.selection.choice import choose
from stickslip.identification.sliding import (
    checked_logs,
    friction_curve,
    log_offsets,
    position_force,
)
from stickslip.identification.sliding.regression import Regression
from stickslip.identification.sliding.stribeck import Rise
from stickslip.identification.stages import friction_map
from stickslip.identification.stages.inertia import _evaluated, measure_inertia
from stickslip.logs import (
    Recording,
    checks,
    force_path,
    grid,
    motion,
    plausibility,
    same_command,
    sampling,
    units,
)
from stickslip.logs import reading as log_reading
from stickslip.logs.checked import shortened
from stickslip.logs.excitation import Excitation, TurnAround, is_one_way
from stickslip.logs.joined import join
from stickslip.loops.family_cost import FamilyCost
from stickslip.loops.other_gains import OtherGains
from stickslip.planning import LINEAR, Limits, arrange
from stickslip.planning.shown import DataSheet, not_shown
from stickslip.rigs import contract, served_drive, socket_rig
from stickslip.rigs.contract import Command, Log
from stickslip.rigs.limits import RigLimits
from stickslip.servo import observer
from stickslip.servo.axis import LOOP, Axis, ControlError, Datasheet
from stickslip.servo.measurement import smoothed
from stickslip.servo.systems import Compensator
from stickslip.servo.velocity_loop import design_velocity_loop
from stickslip.studies.learn import controller_findings
from stickslip.studies.learn.document import loaded
from stickslip.studies.learn.verdict import LoopShare
from stickslip.studies.tune.on_rig import RigTest
from stickslip.studies.tune.run import is_unfinished
from stickslip.studies.validate import compared_logs, log_prediction, log_verdict
from stickslip.trial import compensator_trial
from stickslip.trial.benefit import NONE, MotionErrors, TrialError, harmful
from stickslip.trial.candidates import CompensatorComparison, Row
from stickslip.trial.family import (
    SLOW_MOVE,
    SWEEP,
    Drive,
    Evidence,
    deflections,
    family,
    hidden_deflections,
    onsets,
)
from stickslip.trial.hold import Hold, hunting_at_rest
from stickslip.tuning import loop_learning, refinement
from tests.stickslip.identification.selection.test_choice import predicted
from tests.stickslip.logs.rigid_drive import rigid_drive
from tests.stickslip.tuning.test_drive_model import models

ROOT = Path(thresholds.__file__).parents[2]
MODULES = thresholds.modules()
NAMES = {
    f"{room}.{name}": (value, text)
    for room, module in MODULES.items()
    for name, value, text in thresholds.meanings(module)
}
estimation_learn = sys.modules[
    "stickslip.identification.estimation.learn"
]  # its name is a function's
AXIS = Axis(5.557, 6.6135, 1e-4)
FRICTION = {
    "F_s": 9.0, "F_c": 6.0, "v_s": 5.57e-4, "sigma_0": 3.9e5, "sigma_1": 4.4e3, "delta": 1.0,
}  # fmt: skip
T_S = 5e-4
namespace: Any = SimpleNamespace


def raises(call, *errors):
    """Return whether a call raises one of some errors."""
    try:
        call()
    except errors:
        return True
    return False


SPACE = ParameterSpace.of(friction_law())


def evidence(step=None, space=SPACE):
    """Return the drives that a log supports whose F_s and sigma_0 are 1, and poorly identified."""
    found = [
        replace(predicted(law, error), parameters=FRICTION, plausible=(FRICTION,))
        for law, error in RIVALS
    ]
    known = {
        one: namespace(value=1.0, low=1e-3, high=99.0, identifiability=LEVELS[one in POOR])
        for one in space.friction
    }
    drive = namespace(fit=namespace(space=space), known=known, law=space.law, parameters={})
    drive.plausible, drive.largest_friction = 16 * [dict.fromkeys(space.friction, 1.0)], 9.0
    drive.held_out = namespace(predictions=found)
    drive.recording = namespace(encoder_step=step)
    return compensator_trial.known_friction(drive, 1.0, LearnSettings().friction_range).draws


def test_what_is_drawn_of_a_ratio_stays_within_its_limits():
    elastic = ParameterSpace.of(friction_law("elasto_plastic"))
    drawn = [one["z_ba"] for one in evidence(space=elastic)["elasto_plastic"][1:]]
    assert 0.9 < max(drawn) <= 0.99


def most(name):
    return max(one[name] for one in evidence()["lugre"])


RIVALS = (("lugre", 1.0), ("coulomb_stribeck", 2.0))
POOR = ("F_s", "sigma_0", "z_ba")
POOR_ONE = {"F_c": 1.0, "sigma_0": 1.0}


WORSE_ON_SOME = tuple(TrialError(1.0, "", 1.0, ratio) for ratio in (0.5, 0.6, 1.0, 1.1, 1.1))
WORSE_ON_ONE = tuple(TrialError(1.0, "", 1.0, ratio) for ratio in (0.5, 0.6, 1.0, 1.0, 1.5))
SLOW_MOVES = tuple(TrialError(1.0, f"{r}", 1.0, r, SLOW_MOVE) for r in (0.9, 1.5, 2.7))
BESIDE = tuple(TrialError(1.0 + r, "", 1.0, r, SWEEP[1]) for r in (0.9, 1.5, 2.7))
COARSE = Drive("lugre", "lugre", {"F_c": 6.0, "sigma_0": 6e5})
RIGID = Drive("rigid", "coulomb_stribeck", {"F_c": 6.0, "F_s": 9.0})
FAST = cosim.Trapezoid(height=0.04, slope=0.8, plateau=0.1, begin=0.1)


def later():
    """Return the onsets of observers where the deflection is 10 encoder steps."""
    known = {"sigma_0": FRICTION["F_c"] / 1e-5}
    own = {**FRICTION, **known}
    drives = family(friction_law(), own, FAST, Evidence())
    return onsets(friction_law(), drives, FAST, 1e-6)


def stiffest(step):
    """Return the largest of the stiffnesses that a log shows as 1, with F_c = 1."""
    return max(one["sigma_0"] for one in compensator_trial.stiffer(4 * [POOR_ONE], step))


def assumed_limit():
    """Return the largest force of a motor whose limit is not known, over that in the log."""
    log = SimpleNamespace(recording=DRIVE, force_limit=None)
    figures = SimpleNamespace(measured=np.array([1.0, -2.0]))
    learned = SimpleNamespace(figures=figures, recording=DRIVE, controller=None)
    return compensator_trial.datasheet_of(log, learned, 0.1, 0.0).peak_force / 2.0


def is_at_rest(swing, reversals):
    """Return whether a swing at rest, in encoder steps, is warned of."""
    found = {NONE.name: Hold(swing, reversals, 1.0, "any")}
    return bool(hunting_at_rest(found, NONE, 1.0))


def chosen(mean):
    """Return which is recommended: static feedforward, or what leaves ``mean`` times its error."""
    rows = [
        Row(
            name,
            k,
            1.5,
            namespace(mean_ratio=error, weighed=error, acceptable=True, worst_ratio=1.0),
        )
        for k, (name, error) in enumerate({"static": 0.5, "observer": 0.5 * mean}.items())
    ]
    return CompensatorComparison(tuple(rows)).chosen.name


def alone(mean):
    """Return what is written where one compensator leaves ``mean`` of the error."""
    both = {
        "none": None,
        "it": namespace(mean_ratio=mean, weighed=mean, acceptable=True, worst_ratio=1.0),
    }
    rows = [Row(name, k, 1.5, benefit) for k, (name, benefit) in enumerate(both.items())]
    return CompensatorComparison(tuple(rows)).chosen.name


def designed(reversal):
    """Return the basis on which an observer is designed, which leaves a share of the error."""

    def best(search, start):
        basis = "reversals" if search.loudest else "whole error"
        return start._replace(observer=True, weights=basis, reversal=reversal * start.reversal)

    with patch.object(observer._Search, "best", best):
        try:
            loop = design_velocity_loop(AXIS, LOOP)
            return observer.design_observer(loop, 1e-6, 6.0).weights
        except ControlError:
            return None


def checked(error, factor=1.0):
    return ControllerCheck(np.zeros(1), error, 0, {}, factor=factor)


def criterion(error):
    """Return how a log is fitted whose controller commands the force with this error."""
    task = namespace(
        settings=namespace(criterion="auto", law="lugre"),
        recording=namespace(friction=None, force=True, friction_factor=None),
    )
    return estimation_task.choose(task, checked(error))[0]


def is_foreign(error):
    """Return whether a rig's log whose controller differs is warned of."""
    with patch.object(controller_findings, "check_reading", lambda _: checked(error)):
        return bool(list(controller_findings.check_rig(None)))


def scale_of_force(noise):
    """Return the factor found between logged and commanded force, with noise beside it."""
    force, rest = np.sin(0.01 * np.arange(5000)), np.cos(0.01 * np.arange(5000))
    found = replace(checked(0.9), force=force)
    return controller_check._factor(2.0 * force + 2.0 * noise * rest, T_S, found)


def errs_otherwise(ratio):
    """Tell whether a simulated loop that errs so much of the measured error is another one."""
    size = {"measured": 1.0, "without": ratio, "compensated": None, "frictionless": 0.1}
    return bool(LoopShare("velocity", "mm/s", "", **size, remedy="", remedied=0.1).mismatch)


def shows_gains(noise):
    """Return whether a log shows a PI controller beside a force with a share of the variance."""
    t = np.arange(20000) * T_S
    recording = Recording(t, np.zeros_like(t), velocity_command=np.sin(9.0 * t))
    force = 100.0 * np.sin(9.0 * t) + 100.0 / 9.0 * (1.0 - np.cos(9.0 * t))
    other = np.sqrt(2.0 * noise * np.var(force) / (1.0 - noise)) * np.sin(23.0 * t)
    return compensator_trial.shown_gains(replace(recording, force=force + other)) is not None


def log_errors(relative=0.2, changes=(), ratio=9.0, drift=(0.0, 0.1), controller=None):
    """Return what a learned drive predicts of a log."""
    changes = {name: log_prediction.Change(value, value, value) for name, value in changes}
    goodness = namespace(velocity_recorded=np.array([0.1]), simulated=())
    signals = {"force": namespace(relative=relative, ratio=ratio)}
    return namespace(
        signals=signals, changes=changes, drift=drift, check=controller, goodness=goodness
    )


def verdict(**given):
    values = {"m": 1.0, "b": 1.0, "F_c": 10.0, "F_0": 0.0}
    return " ".join(log_verdict.verdict(log_errors(**given), values))


def changed(name, value):
    """Return whether a change from the learned drive counts."""
    values = {"m": 1.0, "b": 1.0, "F_c": 10.0}
    return bool(list(log_verdict.material(log_errors(changes=[(name, value)]), values)))


def explained(error):
    """Return the error that the standard error of a parameter explains."""
    signals = lambda values: np.full(3, values["F_c"])  # noqa: E731
    return float(log_prediction._spread(signals, {"F_c": 1.0}, {"F_c": error})) > 0.0


def compared(shared, repetitions=8):
    """Return two logs with the same command for a share of the time."""
    t = np.arange(8000) * 1e-3
    moves = np.sin(2.0 * np.pi * np.arange(8000) * repetitions / 8000.0) * 0.1
    other = np.where(np.arange(8000) < shared * 8000, moves, 0.1 * np.sin(40.0 * t**1.5))
    logs = [Recording(t, np.cumsum(v) * 1e-3, velocity_command=v) for v in (moves, other)]
    return compared_logs.common(*logs)


def parts(repetitions):
    """Return whether repetitions of a command are the parts over which errors are compared."""
    command = np.tile(np.append(np.sin(np.linspace(0.0, 6.2, 990)), np.zeros(10)), repetitions)
    stretch = compared_logs.Overlap(0, 0, len(command))
    return compared_logs._parts(command, [stretch], 1e-3)[1]


def faults(delay=5.0, change=(0.0, 0.1), error=0.0, bent=0.0):
    """Return what spoils intervals of a fit, by its delay, with an error, and a change of friction.

    Delays are in samples, the deflection is one of the travel.
    """
    ends = {"lower": np.array([-5.0]), "upper": np.array([20.0]), "units": np.array([T_S])}
    space = namespace(index=lambda _: 0, law=SPACE.law, **ends)
    fitted = namespace(space=space, q=np.array([delay]))
    given = {"change": change, "delay_error": error * T_S, "bent": bent}
    found = estimation.faults.found_faults(fitted, "inverse model", None, np.nan, **given)
    return [one.what.partition(" of")[0] for one in found if one.spoils == "intervals"]


def is_coarse(step):
    """Return whether an encoder whose step is a share of the motion in a sample is coarse."""
    inverse = namespace(motion=namespace(v=np.ones(9)))
    return bootstrap.coarse(inverse, namespace(encoder_step=step * T_S, T_s=T_S))


def samples_per_row(rate, noise):
    """Return it for a log of a sine of 100 rad/s, with encoder noise in amplitudes."""
    x = np.sin(100.0 / rate * np.arange(100_000))
    x += noise * np.random.default_rng(0).standard_normal(len(x))
    recording = Recording(np.arange(len(x)) / rate, x, x)
    return inverse_model.row_length(recording)


def cutoff():
    """Return that of the low-pass for moves of seven samples at 100 Hz."""
    t = 0.01 * np.arange(1000)
    x = 1e-3 * np.sin(2.0 * np.pi * 7.0 * t)
    with candidate_fmus() as fmus:
        return inverse_model.InverseModel(fmus, Recording(t, x, x)).cutoff


def estimated(variance=1.0):
    """Return a curve with friction of 1 N, and ripple of 9 standard errors.

    It is None for a motion that gives no curve.
    """
    estimate = np.ones(4), variance * np.eye(4), np.array([9.0, 0.0, 0.0]), np.ones(3)
    x = np.sin(np.linspace(0.0, 30.0, 4000))
    with (
        patch.object(friction_curve._Rows, "estimate", lambda *_: estimate),
        patch.object(friction_curve._Rows, "speeds", lambda *_: np.ones(1)),
    ):
        return friction_curve.friction_curve(x, x, T_S, 1e-6)


def curve():
    """Return the forces beside a law that sliding shows."""
    found = estimated()
    return found and set(found.varying)


def constant_force():
    """Return the half-width of the interval of a constant force that is known exactly."""
    found = estimated(1e-12).offset
    return round(found.high - found.value, 6)


def holds(force=1.0, error=0.01):
    """Return whether an arm's weight is shown, with friction of 1 N."""
    terms, eight = position_force._Terms(gravity=True, coefficients=(1.0, 1.0)), np.ones(8)
    shown = {"gravity": (force * eight, error * eight)}
    values = np.ones((8, 3))
    found = position_force._Estimates(terms, values, values, shown, {"gravity": True}, 0.0)
    return found.kept(1.0) is not None


def has_cogging(left):
    """Return whether an arm has cogging, without which it leaves a share of the force."""

    def rest(_, terms):
        return (left if terms.orders else 1.0), np.ones(8)

    x = np.linspace(0.0, 1.0, 99)
    with patch.multiple(position_force._Rest, left=rest, pitch=lambda *_, **__: 0.1):
        return bool(position_force._Rest(x, 9.0 * x, 1.0, 0.0).terms(rotary=True).orders)


def falls(weight):
    """Return whether an axis has a weight, over friction."""
    rest = namespace(friction=1.0, offset=weight, terms=lambda **_: None)
    log = namespace(beside_friction=lambda: rest, estimates=lambda _: namespace(force=lambda: 1))
    log.aligned = lambda _: (log, None)
    return position_force._shown(log, rotary=False) is not None


def left_to_the_loop(weight):
    """Return the force that an observer leaves to the loop, with friction of 1 N."""
    estimation = namespace(parameters={"F_0": weight})
    learned = namespace(estimation=estimation, friction={"F_c": 1.0}, position_force=None)
    return loaded(Compensator("observer", "dob"), learned).values.get("F_0")  # noqa: PD011 - a mapping


def static_friction(deviance):
    """Return F_s of a curve that the exponent 2, beside 1, explains with a deviance."""

    def rise(*of):
        found = np.array([1.0, 0.99, 1.01]) * of[-1]
        return Rise(found, found, deviance if of[-1] == 2.0 else 1.0)

    eight = namespace(speeds=None, values=np.ones((8, 4)), covariances=np.ones((8, 4, 4)))
    with patch.object(friction_curve, "rise", rise):
        return round(friction_curve._rise(eight)["F_s"].high)


def gives_rise(deflection):
    """Return whether the curve gives F_s of a drive whose bristles bend, over the travel needed."""
    start = Start({}, SPACE, namespace(near=1.0))
    return not start.is_bent({"F_c": deflection, "sigma_0": 1.0})


def least_shown(**sheet):
    """Return the Stribeck velocity that a plan is said to show of a drive [mm/s]."""
    said, *_ = not_shown(DataSheet(**sheet), LINEAR, arrange(), ("mm", 1e-3))
    return float(said.partition("below ")[2].split()[0])


def not_explained(apart=0.0, varying=0.0, **_):
    """Return whether the force decides instead of the simulated loop."""
    shown = namespace(value=np.ones(1), varying={"ripple": varying})
    start = namespace(disagreement=lambda _: apart, curve=shown)
    corrected = namespace(model_error=1.0, fit=namespace(parameters={}))
    return bool(estimation_learn._not_explained(corrected, start))


def is_less(gain, spread):
    """Return whether squared errors that vary by block are less by a share of the others."""
    sign = np.resize([1.0, -1.0], 40)
    return held_out.is_less(np.exp(spread * sign - gain), np.ones(40))


def law(error):
    """Return the law that is chosen for its error over Coulomb's, with no parameter identified."""
    plain = predicted("coulomb_stribeck", 1.0, is_level=True)
    return choose([plain, predicted("gms", error, shown=())]).chosen.candidate.law.name


def with_least_error(error, encoder_step=0.0, name="sigma_0"):
    """Return the standard error of a value of 1 that a fit gives another one."""
    values = {"sigma_0": 1.0, "F_c": 1.0, name: 1.0}
    return identifiability.least_errors(
        {name: error}, values, ["sigma_0"], encoder_step=encoder_step
    )[name]


def stiffness(error):
    """Return the upper end of the interval of sigma_0 beside another law with ten times as much."""
    chosen, other = (
        replace(predicted(name, force), parameters={"sigma_0": sigma_0})
        for name, force, sigma_0 in (("lugre", 1.0, 1.0), ("gms", error, 10.0))
    )
    alike = choice.Choice((chosen, other), chosen, "").alike
    known = {"sigma_0": Identifiability(1.0, 0.1, 0.8, 1.2, "identifiable", "")}
    others = [one.parameters for one in alike]
    return identifiability.among_laws(known, others, SPACE)["sigma_0"].high


def tied(error):
    """Return whether friction with F_s = F_c is taken, whose error is larger by chance."""
    squares = np.array([[1.0, 0.0], [0.0, error**2 + 1.0]]).repeat(20, axis=1)
    plain, other = (
        predicted("coulomb_stribeck", error, is_level=True),
        predicted("coulomb_stribeck", 1.0),
    )
    both = [replace(one, squares=of) for one, of in zip((plain, other), squares, strict=True)]
    return choose(both).chosen.candidate.is_level


def seen(rise):
    """Return what a fit shows of the Stribeck curve, whose rise is so many standard errors."""
    fitted = namespace(space=SPACE, errors=dict, q=np.full(len(SPACE.names), rise))
    fitted.covariance = np.eye(len(SPACE.names))
    with patch.object(prediction, "identifiability", lambda *_: namespace(identifiability="")):
        return "v_s" in prediction._shown(fitted)


def contradicts(gain, share=1.0, own=0.0):
    """Return whether a log does without which the squares of the other are divided by a gain.

    What it adds to the error of the other is a share of its force, and its own values leave so
    many times the error of the other.
    """
    squares = iter(([gain, gain], [1.0, gain], [1.0, gain], [1.0, 1.0]))
    inverse = namespace(recording=namespace(segments=[namespace(source=one) for one in "ab"]))
    inverse.measured = lambda _: np.array([np.sqrt(gain - 1.0) / share])
    with patch.multiple(
        agreement,
        _squares=lambda *_: next(squares),
        _without=lambda *_: {},
        _rows=lambda *_: [0],
        _differences=lambda *_: (["its friction"], own**2 * share**2 / (gain - 1.0)),
    ):
        return bool(list(agreement.contradictions(inverse, namespace(parameters={}))))


def differs(share):
    """Return whether it is said that the friction of a log is larger by a share."""
    v = np.sin(np.linspace(0.0, 60.0, 2000))
    inverse = namespace(
        t=v,
        used=slice(0, 2000),
        logs=[slice(0, 2000)],
        moves=v != 9.0,
        T_s=T_S,
        cutoff=200.0,
        motion=namespace(v=v),
        linear=np.column_stack([0.0 * v, 0.0 * v, np.ones_like(v)]),
        friction=lambda _: np.sign(v),
        measured=lambda _: (1.0 + share) * smoothed(np.sign(v), T_S, 200.0),
    )
    values = {"m": 1.0, "b": 0.0, "F_c": 1.0, "F_0": 0.0}
    return any("friction" in one for one in agreement._differences(inverse, values, 0)[0])


def is_own_offset(errors):
    """Return whether a constant force of a log that is so many standard errors counts."""
    both = join([rigid_drive(), rigid_drive()], [None, None], [0.0, 0.0])
    found = Regression(np.array([3.0, 20.0, 4.0, 0.0, 1.0]), np.eye(5) / errors**2, {})
    with patch.object(log_offsets, "regress", lambda *_: found):
        return log_offsets.with_log_offsets(both)[0] is not both


def share_of_each(logs):
    """Return which share of the longest stretch each of several logs may take."""
    shares = []
    reads = patch.object(checked_logs, "_read", lambda *of: shares.append(of[1]))
    with reads, suppress(AttributeError):  # nothing was read
        [*checked_logs.check_logs([None] * logs)]
    return shares[0]


def fits(noise):
    """Return two fits by their mean square, 1 of the first."""
    space = namespace(names=("F_c",))
    return [
        namespace(noise=one, q=np.zeros(1), covariance=np.eye(1), space=space)
        for one in (1.0, noise)
    ]


def exponent(noise):
    """Return the mean square of the exponent that is taken of a law without presliding."""
    rigid = namespace(law=friction_law("coulomb_stribeck"))
    return search.select(fits(noise), estimation_learn._sure(rigid)).fit.noise


def flat(noise):
    """Return whether a rise towards rest is left out, at the cost of a larger mean square."""
    found = namespace(errors=dict, space=SPACE, noise=1.0, q=np.ones(len(SPACE.names)))
    hidden = namespace(identifiability=NOT_IDENTIFIABLE)
    with patch.multiple(
        search, identifiability=lambda *_: hidden, fit=lambda *_: namespace(noise=noise)
    ):
        return search.without_stribeck(namespace(over=id), found) is not found


def warning(found, *causes):
    """Return the finding that a law does not explain a log."""
    (one,) = choice.mismatch(found, [], causes, rotary=False)
    return one


def level(half):
    """Return how well F_c is identified by the relative half-width of its interval."""
    interval = friction_curve.Interval(1.0, half / 2.0, np.exp(-half), np.exp(half))
    return identifiability._classified("F_c", interval, SPACE).identifiability


def is_prior(share):
    """Return whether the prior decides a value with a standard error that is a share of its own."""
    one = np.ones(1)
    space = namespace(index=lambda _: 0, rise=(), bounded={}, prior_deviation=one, lower=-one)
    space.upper = one
    fitted = namespace(space=space, q=np.zeros(1), covariance=share**2 * np.eye(1))
    return identifiability._is_prior_dominated("F_c", fitted)


def taken(name, value, half=None):
    """Return what the compensator takes of a value; the largest force in the log is 8 N."""
    levels = {"F_s": "weakly identifiable", "sigma_0": NOT_IDENTIFIABLE}
    known = {
        one: Identifiability(at, 0.0, 0.0, 9.0 * at, levels.get(one, "identifiable"), "")
        for one, at in {**FRICTION, name: value}.items()
    }
    if half:
        ends = {"low": value * np.exp(-half), "high": value * np.exp(half)}
        known[name] = replace(known[name], identifiability="weakly identifiable", **ends)
    return conservative(known, SPACE, 8.0)[name].value


def rig(x, v=None):
    """Return a rig whose encoder shows a position (n,), or that of a velocity (n,), in 0.4 um."""
    x = np.cumsum(v) * T_S if x is None else x
    log = namespace(x_enc=x, F_m=np.cos(np.linspace(0.0, 20.0 * np.pi, len(x))))
    sheet = namespace(peak_force=1.0, encoder_step=4e-7)
    return namespace(
        samples=lambda _: np.arange(len(x)) * T_S,
        push=lambda _: log,
        follow=lambda *_: log,
        datasheet=sheet,
        T_s=T_S,
    )


def inertia(amplitude, step):
    """Return why the mass is not found from a motion and the steps of its encoder, in 0.4 um."""
    x = -amplitude * np.cos(np.linspace(0.0, 20.0 * np.pi, 4001))
    try:
        measure_inertia(rig(4e-7 * step * np.round(x / (4e-7 * step))))
    except IdentificationError as fault:
        return str(fault)
    return ""


def held(speeds):
    """Return whether so many speeds that are held give friction against speed."""
    force = np.ones(40)
    runs = [(np.array([force, -force]), 0.1)] * speeds + [None] * (12 - speeds)
    with patch.object(friction_map, "_forth_and_back", side_effect=runs):
        return not raises(lambda: friction_map.measure_sliding(None, None), IdentificationError)


def fluctuates(share):
    """Return whether a speed counts as held whose velocity fluctuates by a share of it."""
    v = np.where((np.arange(12000) < 500) | (np.arange(12000) >= 6500), -0.04, 0.04)
    wave = 1.0 + np.sqrt(2.0) * share * np.sin(2.0 * np.pi * 5.0 * T_S * np.arange(12000))
    loop = namespace(axis=AXIS)
    return friction_map._forth_and_back(rig(None, v * wave), loop, 0.04) is None


def rises(share):
    """Return whether friction that rises towards rest by a share gives v_s."""
    speed = np.geomspace(1e-3, 0.04, 12)
    force = 6.0 * (1.0 + share * np.exp(-speed / 4e-3))
    shown = friction_map.Sliding(speed, force, -force, force, 1e-4 * force, np.ones(9), 1e-9)
    with (
        patch.object(friction_map, "measure_sliding", lambda *_: shown),
        patch.object(friction_map, "_break_away", lambda *_: (6.0 * (1.0 + share), 1.0)),
    ):
        return "does not rise" not in friction_map.measure_friction(None, None, 6.0).warning


def breaks_away(speed, samples):
    """Return whether a stage breaks away that moves at a speed at the end of a ramp."""
    v = np.where(np.arange(4000) < 4000 - samples, 0.0, speed)
    return not raises(lambda: friction_map._break_away(rig(None, v), 1.0, 1.0), IdentificationError)


def presliding_warning(left):
    fit = namespace(jac=np.eye(3)[:, :1], fun=np.ones(3), x=np.ones(1))
    return _evaluated(fit, np.ones(1), left)[2]


def rigid_log(**changes):
    """Return a log of a rigid drive, whose force is logged with an error."""
    drive = rigid_drive(step=4e-7, **changes)
    noise = 0.5 * np.random.default_rng(0).standard_normal(len(drive.t))
    return replace(drive, force=drive.force + noise)


def shows(**changes):
    """Return how many parameters a log shows poorly."""
    found = checks._visibility(DRIVE, replace(SHOWN, **changes))
    return sum(one.severity == "warning" for one in found)


SHOWN = Excitation(
    *(0.1, 0.5, 1e-3, 0.2, 100, (0.01, 0.1), 10, False, 100.0, 1.0, 1.0, 1.0, 0.3),
    TurnAround(1e-5, 30.0, 30.0, 50),
)
DRIVE = rigid_drive()


def is_rigid(samples):
    """Return whether a drive that slides for some samples shows its mass."""
    slides = np.arange(len(DRIVE.t)) < samples
    with patch.object(motion, "sliding", lambda *_: slides):
        return motion.rigid(DRIVE, motion.kinematics(DRIVE)) is not None


def is_cut(samples, T_s):
    t = T_s * np.arange(samples)
    return bool(shortened(Recording(t, np.sin(t)))[1])


def is_short(duration, samples):
    t = np.linspace(0.0, duration, samples)
    return bool(list(checks._duration(Recording(t))))


def is_short_travel(steps):
    log = Recording(np.arange(9) * T_S, steps * np.linspace(0.0, 1.0, 9), encoder_step=1.0)
    return next(checks._quantisation(log, SHOWN)).severity == "warning"


def one_way(share):
    v = np.where(np.arange(1000) < 1000 * share, -1.0, 1.0)
    return is_one_way(namespace(v=v, floor=0.5))


TABLE: Any = namespace(path="log.csv", row=int, part=lambda _: TABLE)


def on_grid(samples=100, gap=0, jitter=0.0):
    """Return how grave it is to put a log with a gap and uneven times [samples] on a grid."""
    t = np.arange(float(samples))
    t[50:] += gap
    t += jitter * np.sqrt(2.0) * np.sin(np.arange(samples) ** 2)
    try:
        found = grid.even_grid(TABLE, 1e-3 * t, {"force": np.sin(0.1 * t)})[2]
    except RecordingError:
        return ["refused"]
    return [one.severity for one in found if "interpolated" not in one.what]


def is_rounded(steps):
    """Return whether times that deviate by steps of their clock both ways are those of a clock."""
    t = np.arange(0.0, 1000.0, 10.0)
    t[[40, 60]] += steps, -steps
    return sampling.regular_times(t, 10.0) is not None


def is_refused(still):
    """Return whether rows with equal times are refused, for their motion over that beside them."""
    x = np.cumsum(np.resize([0.0, 1.0, still, 1.0], 400))
    t = np.cumsum(np.resize([1.0, 1.0, 0.0, 1.0], 400))
    return raises(lambda: sampling._check_instants(TABLE, t, {"position": x}), RecordingError)


def in_turn(share):
    one = np.where(np.arange(1000) % round(1.0 / share) == 1, np.nan, 1.0)
    return sampling._in_turn({"force": one}) == "force"


def is_limited():
    """Return whether a force is found to be logged before a limit."""
    at = np.quantile(np.abs(DRIVE.force), 0.7)
    beyond = 2.0 * np.sign(DRIVE.force) * np.maximum(np.abs(DRIVE.force) - at, 0.0)
    log = replace(DRIVE, force=DRIVE.force + beyond)
    return force_path._before_limit(log, log.force) is not None


def is_cut_off(share, beyond=0.3, spread=0.0):
    """Return whether a log cuts a force off in a share of the samples, which the motion exceeds."""
    n, many = 10_000, round(10_000 * share)
    force = np.sin(np.arange(n))
    force[:many] = 1.5 * (1.0 + beyond)
    logged = force.copy()
    logged[:many] = 1.5 * np.linspace(1.0 - spread, 1.0, many)
    drive = namespace(used=np.full(n, True), columns=force[:, np.newaxis], force=logged)
    motion = namespace(cutoff=100.0)
    with patch.multiple(force_path, rigid=lambda *_: drive, kinematics=lambda _: motion):
        return force_path._clipped(namespace(T_s=1e-3), logged) is not None


def is_low_passed():
    """Return whether a force behind a low-pass of 10 Hz, which leaves 0.4 % of it, is found."""
    drive, share = rigid_drive(F_c=0.3), -np.expm1(-0.02 * np.pi)
    force = scipy.signal.lfilter([share], [1.0, share - 1.0], drive.force)
    shown = replace(drive, force=force)
    return force_path._low_passed(shown, motion.force_delay(shown)) is not None


def saturates(level, samples, asked=None, limit=10.0):
    """Return what is found of a force that stays at a level, where a command may ask for more."""
    force = 0.3 * level * np.sin(np.arange(4000.0))
    force[1000 : 1000 + samples] = level
    command = np.where(force == level, asked, force) if asked else None
    log = Recording(np.arange(4000) * 1e-3, np.zeros(4000), force, force_command=command)
    found = checks.saturation(log, limit)
    return {one.what.split()[1] for one in found if one.what.startswith("force ")}


def lost(events):
    """Return whether rows are lost where the position goes twice as far in one step."""
    steps = 1.0 + 1e-3 * np.sin(np.arange(1000.0))
    steps[20 : 20 + 40 * events : 40] *= 2.0
    return checks.lost_rows(namespace(position=np.cumsum(steps), encoder_step=0.0)) is not None


def jump(size, noise):
    """Return whether a jump in a signal whose steps are 1, and deviate by a noise, is found."""
    steps = 1.0 + noise * np.sin(np.arange(200.0) ** 2)
    steps[100] += size
    return bool(grid.jumps(np.arange(201.0), np.cumsum(np.append(0.0, steps)))[0].size)


def restart(*sizes):
    """Return the size of jumps after which a counter restarts, which is that of no turn or word."""
    return grid._restart("position", np.linspace(0.0, 3.0, 90), np.array(sizes), np.zeros(1))


def contradicting(ratio=1.0, high=0.9, other="position_command", **given):
    """Return how gravely a position and another signal, or a force, contradict each other."""
    reading = namespace(
        recording=DRIVE,
        units=dict.fromkeys(("position", other, "force")),
        timed=other == "velocity",
        description=namespace(column=lambda _: namespace(scale=None)),
        controller=namespace(T_s=given.get("T_s", 0.0)),
    )
    with patch.multiple(
        plausibility,
        _likeness=lambda *_: (ratio, high, 0.0),
        _shared=lambda *_: given.get("shared", 1.0),
        _corrections=lambda *_: "",
    ):
        return [one.severity for one in plausibility.contradictions(reading)]


def shared(share):
    """Return whether the share of a force like that of a motion is known, for a time in motion."""
    v = np.where(np.arange(4000) < 4000 * share, np.sin(np.arange(4000.0)), 0.0)
    motion = namespace(v=v, a=v, floor=1e-3, cutoff=100.0)
    return plausibility._shared(DRIVE, DRIVE.force, motion) < 1.0


def is_slow(T_s):
    """Return whether a sample period of a time without a unit is asked about."""
    log = replace(DRIVE, t=np.arange(len(DRIVE.t)) * T_s)
    found = plausibility.implausible(namespace(recording=log, assumed=("time",), units={}))
    return next(found, None) is not None


def other_steps(shown):
    """Return whether steps of a position are warned of, over the step that was stated."""
    findings: list[Any] = []
    x = {"position": shown * np.round(9.0 * np.sin(0.1 * np.arange(100.0)))}
    with patch.object(log_reading, "_positive", lambda *_: 1.0):
        log_reading._encoder_step(TABLE, None, x, findings)
    return bool(findings)


def in_common(factor=1.0, samples=2000):
    """Return in how many samples a command is the same in another log."""
    first = np.sin(0.01 * np.arange(2000.0))
    second = np.where(np.arange(2000) < samples, factor * first, np.sin(np.arange(2000.0) ** 1.5))
    return sum(one.n for one in same_command.same_command(first, second, 1e-3)) > 300


def refined(worse):
    """Return what is kept of the friction where a fit costs more than the start by a factor."""
    runs = [namespace(cost=cost, gaps=[0] * 3, values={}, training_cost=0.0) for cost in (1, worse)]
    bench = namespace(run=lambda _: runs.pop(0) if len(runs) > 1 else runs[0], runs=0)
    study = namespace(start={}, rig=namespace(samples=lambda _: 0, T_s=T_S))
    motion = namespace(command=namespace(sample=lambda _: 0), duration=1.0)
    with patch.multiple(
        refinement,
        Bench=lambda *_: bench,
        guard_motion=lambda _: motion,
        relative_errors=lambda *_: {"creep": 1.0},
        fit=lambda *_: namespace(values={}, errors={}, alone={}),
    ):
        return refinement.refine(study).chosen


def taken_loop(worst):
    """Return which loop is taken: one with a part of the reference's errors, but one of them."""
    names = [gene.name for gene in loop_learning.GENES]
    history = pd.DataFrame([dict.fromkeys(names, 0.5) | {"cost": 0.5}])
    found = iter([{"a": worst, "b": 0.3}, {"a": 9.0, "b": 9.0}, {"a": 1.0, "b": 1.0}])
    loop = namespace(peak_sensitivity=lambda: 1.5)
    study = namespace(seed=0, loop=lambda _: loop, models=())
    with patch.object(loop_learning, "_typical", lambda *_: next(found)):
        search = namespace(history=history, evaluations=1, names=names)
        return loop_learning._choose(study, None, search).chosen


def is_within(chatter=0.0, peak=0.0):
    """Return whether a tuned loop with forces [N] keeps the limits; friction and limit are 1 N."""
    bench = namespace(datasheet=Datasheet(peak_force=1.0))
    cost = namespace(sensitivity=lambda _: 1.0, forces=lambda _: (chatter, peak), bench=bench)
    cost.F_c, cost._own = 1.0, (0.01, 0.1)
    cost._too_much = lambda forces: FamilyCost._too_much(cost, forces)
    return FamilyCost.excess(cost, None) <= 1.0


def goes_on(ripple=0.0, ratio=1.0):
    """Return whether a rig goes on after a motion; friction and force limit are 1 N and 100 N."""
    test = namespace(learned=namespace(friction={"F_c": 1.0}), _peak=100.0, _unit=str)
    test.rig = namespace(datasheet=Datasheet())
    present = namespace(force=1.0, ripple=1.0, hold=Hold(0.0, 0, 1.0))
    found = namespace(force=1.0, ripple=ripple, hold=present.hold, ratios=(ratio,), loop="")
    found.motion = ""
    return not RigTest.worse(test, found, present)


def is_run(Ms):
    """Return whether a candidate of the loop with a peak sensitivity is run."""
    loop = namespace(peak_sensitivity=lambda: Ms)
    cost = namespace(study=namespace(loop=lambda _: loop), ratios=lambda _: {"a": 1.0})
    values = np.zeros(len(loop_learning.GENES))
    return not raises(lambda: loop_learning.LoopCost.__call__(cost, values), ga.CandidateFailed)


def is_refused_log(error):
    """Return whether a log is refused whose times are wrong by a share."""
    t = np.arange(9) * T_S
    command = Command(T_S / (1.0 + error), design_velocity_loop(AXIS, LOOP), velocity=np.zeros(9))
    return contract._wrong_log(Log(t, t, t), command) != ""


def remote_rig(**values):
    limits = RigLimits((-1.0, 1.0), 1.0, 1.0, 1.0)
    known = {"name": "rig", "T_s": T_S, "_motion": 0, "_number": 0, "_heartbeat": 0.0}
    return namespace(**known, _limits=limits, _understood=nullcontext, **values)


def returns(x):
    """Return whether a drive that stands away from where motions begin has returned."""
    loop = namespace(changed=lambda **_: design_velocity_loop(AXIS, LOOP))
    rig = remote_rig(_request=lambda *_, **__: {"position": x}, _run=lambda *_: None, loop=loop)
    return not raises(lambda: socket_rig.SocketRig._return(rig), RigError)


def is_stopped(quiet):
    """Return whether a motion is stopped whose samples come after a time [s]."""
    clock = iter([0.0, quiet, quiet, quiet])

    def request(what, **_):
        if what != "read":
            return {"loaded": 9}
        seen = request.reads = getattr(request, "reads", 0) + 1
        x = [0.0] * 9 if seen > 1 else []
        values = {"x_enc": x, "F_m": x}
        return {"values": values, "state": "done", "limit": 0, "reason": "", "samples": 9}

    rig = remote_rig(_request=request, _stop=id)
    command = Command(T_S, design_velocity_loop(AXIS, LOOP), velocity=np.zeros(9))
    with patch.object(socket_rig, "time", namespace(monotonic=lambda: next(clock), sleep=id)):
        return raises(lambda: socket_rig.SocketRig._run(rig, command, rig._limits), RigError)


def braked(v=0.0, resting=9.0, stopping=0.0):
    """Return the state of a drive that is stopped, has a speed, and is at rest for a time [s]."""
    drive = namespace(T_s=T_S, _v=0.0, _x_cmd=0.0, state="stopping", _velocity=lambda: v)
    drive._resting, drive._stopping = round(resting / T_S), round(stopping / T_S)
    served_drive.ServedDrive._ramp(drive)
    return drive.state


def is_planned(**limits):
    """Return whether an experiment can be planned."""
    return not raises(lambda: Limits(**limits), UsageError)


CASES: dict[str, tuple[Any, object, object]] = {
    # threshold: decision, verdict with its value, and with twice of it, or half where /2 stands
    "harm.WORSE": (lambda: MotionErrors((TrialError(1.0, "", 1.0, 1.03),)).is_worse, True, False),
    "harm.DRIVES/2": (lambda: MotionErrors(WORSE_ON_SOME).is_worse, True, False),
    "harm.MORE": (lambda: MotionErrors(WORSE_ON_SOME).is_worse, True, False),
    "harm.SLOWLY": (lambda: harmful(SLOW_MOVES, 1.0), (SLOW_MOVES[1], 1.3), None),
    "harm.PERSISTS": (lambda: harmful(BESIDE, 3.0), (BESIDE[1], 1.2), None),
    "harm.SCATTER": (lambda: MotionErrors(WORSE_ON_ONE).is_worse, True, False),
    "harm.RESOLVED": (lambda: round(max(hidden_deflections(1.0, 4)), 9), 15.0, 30.0),
    "harm.RESOLVED/2": (lambda: len(later()), 2, 0),
    "harm.ONSET": (lambda: later()[0] > 8e-5, False, True),
    "harm.HIDDEN": (lambda: min(deflections([RIGID], FAST, 4e-7)["rigid"]) > 3e-6, False, True),
    "harm.UNSURE": (lambda: max(deflections([COARSE], FAST, 1e-6)["lugre"]), 1.4e-5, 2.8e-5),
    "harm.COARSE/2": (lambda: stiffest(1.0 / 20.0), 3.0, 1.0),
    "harm.STIFFER": (lambda: stiffest(1.0 / 20.0), 3.0, 4.0),
    "harm.PROMISED": (
        lambda: MotionErrors((TrialError(1.0, "", 1.0, 0.5),)).interval,
        (0.25, 1.0),
        (0.125, 2.0),
    ),
    "harm.LIMIT": (assumed_limit, 10.0, 20.0),
    "harm.FALLS/2": (lambda: LearnSettings().friction_range[0], 0.7, 0.35),
    "harm.GROWS": (lambda: LearnSettings().friction_range[1], 1.3, 2.6),
    "harm.EXPLAINS": (lambda: "coulomb_stribeck" in evidence(), False, True),
    "harm.RESERVE": (lambda: most("F_s") > 11.7, False, True),
    "harm.WIDE": (lambda: most("sigma_0") > 3.0, False, True),
    "caution.SWING": (lambda: is_at_rest(3.0, 2), True, False),
    "caution.REVERSALS": (lambda: is_at_rest(3.0, 2), True, False),
    "offer.GAIN/2": (lambda: alone(0.8), "it", "none"),
    "offer.SIMPLER": (lambda: chosen(0.92), "observer", "static"),
    "offer.SENSITIVITY/2": (lambda: designed(0.5), "whole error", None),
    "offer.WORTHWHILE/2": (lambda: designed(0.6), "whole error", None),
    "offer.HIDDEN/2": (lambda: designed(0.5), "whole error", "reversals"),
    "offer.OTHER_GAINS": (
        lambda: "searches further" in OtherGains(2, 9, (1.2, 1.3), {"K_p": 2.0}, 0.95).sentence,
        True,
        False,
    ),
    "control_match.EXACT": (lambda: criterion(0.015), "inverse model", "output error"),
    "control_match.NEAR": (
        lambda: "controller differs" in verdict(controller=checked(0.07)),
        True,
        False,
    ),
    "control_match.FOREIGN": (lambda: is_foreign(0.5), True, False),
    "control_match.OUT_OF_SCALE/2": (lambda: scale_of_force(0.07) > 1.9, True, False),
    "control_match.OTHER_FORM/2": (
        lambda: controller_check._believed(checked(1.0), checked(0.3)).error,
        0.3,
        1.0,
    ),
    "control_match.GAINS_SHOWN/2": (lambda: shows_gains(0.3), False, True),
    "control_match.ERRS_ALIKE": (lambda: errs_otherwise(0.45), True, False),
    "transfer.SMALL": (lambda: "within" in verdict(relative=0.08), False, True),
    "transfer.MASS": (lambda: changed("m", 0.03), True, False),
    "transfer.VISCOUS": (lambda: changed("b", 7.0), True, False),
    "transfer.FRICTION": (lambda: changed("friction", 0.03), True, False),
    "transfer.OFFSET": (lambda: changed("F_0", 0.3), True, False),
    "transfer.INTERVAL": (lambda: explained(0.2), False, True),
    "transfer.IN_COMMON": (lambda: raises(lambda: compared(0.3), Exception), False, True),
    "transfer.REPETITIONS": (lambda: parts(4), True, False),
    "loop_fit.RUNS_AWAY": (
        lambda: raises(lambda: require_bounded(np.full(9, 15.0), 1.0), Diverged),
        True,
        False,
    ),
    "loop_fit.DELAY_AT_BOUND": (lambda: faults(delay=-4.985), [], ["the delay"]),
    "loop_fit.DELAY_KNOWN": (lambda: faults(error=3.0), ["the delay"], []),
    "loop_fit.SPRING": (lambda: faults(bent=0.3), ["friction turns over much"], []),
    "loop_fit.CHANGE": (lambda: len(faults(change=(0.05, 0.001))), 1, 0),
    "loop_fit.CHANGE_CERTAIN": (lambda: len(faults(change=(0.05, 0.008))), 1, 0),
    "loop_fit.COARSE": (lambda: is_coarse(0.007), True, False),
    "loop_fit.ALIKE": (lambda: bootstrap.is_alike(3.0), False, True),
    "row_rate.FASTEST": (lambda: samples_per_row(10_000.0, 0.0), 2, 1),
    "row_rate.NOISE": (lambda: samples_per_row(2000.0, 6e-3), 2, 1),
    "row_rate.QUICK/2": (cutoff, 25.0, 12.5),
    "curve_shown.ROWS": (curve, {"ripple"}, None),
    "curve_shown.CERTAIN": (curve, {"ripple"}, set()),
    "position_force.SHARE": (lambda: holds(0.015, 1e-4), True, False),
    "position_force.CERTAIN": (lambda: holds(0.09), True, False),
    "position_force.SIMPLER/2": (lambda: has_cogging(0.5), True, False),
    "position_force.HELD": (lambda: left_to_the_loop(0.15), 0.15, None),
    "position_force.FALLS": (lambda: falls(1.5), True, False),
    "curve_shown.OFFSET": (constant_force, 2e-3, 4e-3),
    "curve_shown.EXPONENT": (lambda: static_friction(6.0), 1, 2),
    "curve_shown.BENT": (lambda: gives_rise(4.0), False, True),
    "curve_shown.VARIES": (lambda: not_explained(varying=0.007), True, False),
    "curve_shown.CONTRADICTED": (lambda: not_explained(apart=2.0), True, False),
    "curve_shown.NEGATIVE": (lambda: start._massless(-3.0, 1.0, "")[0].spoils, "intervals", ""),
    "law_choice.STATIC": (lambda: tied(1.2), False, True),
    "law_choice.TIE": (lambda: is_less(0.1, 0.2), True, False),
    "law_choice.MARGIN/2": (lambda: is_less(0.4, 0.0), True, False),
    "law_choice.UNIDENTIFIED/2": (lambda: law(0.5), "gms", "coulomb_stribeck"),
    "law_choice.RISES": (lambda: seen(3.0), True, False),
    "law_choice.RISE_WORTH": (lambda: flat(1.5), False, True),
    "law_choice.ALIKE": (lambda: stiffness(1.5), 1.2, 10.0),
    "law_choice.EXPONENT/2": (lambda: search.select(fits(0.9)).fit.noise, 0.9, 1.0),
    "law_choice.EXPONENT_BIASED/2": (lambda: exponent(0.7), 0.7, 1.0),
    "misfit.NOTED": (lambda: choice.is_mismatch(predicted("lugre", 0.25)), True, False),
    "misfit.EXPLAINED": (
        lambda: (warning(predicted("lugre", 0.3)).spoils, "drive holds" in verdict(ratio=3.0)),
        ("intervals", False),
        ("", True),
    ),
    "misfit.SMALLEST": (lambda: choice.is_mismatch(predicted("lugre", 0.2)), True, False),
    "misfit.BEATEN/2": (
        lambda: choice.is_beaten(predicted("lugre", 1.0, explained=1.0), [predicted("gms", 0.5)]),
        True,
        False,
    ),
    "misfit.LARGE": (lambda: choice.is_large(predicted("lugre", 0.9, explained=0.9)), True, False),
    "misfit.LIKELY": (
        lambda: warning(predicted("lugre", 1.0), choice.Cause("", 0.6, "advice")).advice,
        "advice",
        "take the values as coarse",
    ),
    "identifiable.WELL": (lambda: level(0.08), "weakly identifiable", "identifiable"),
    "identifiable.WEAKLY": (lambda: level(1.0), NOT_IDENTIFIABLE, "weakly identifiable"),
    "identifiable.TAKEN": (lambda: taken("sigma_0", 4e5, half=0.4) < 4e5, True, False),
    "identifiable.PRIOR_DOMINATED": (lambda: is_prior(0.7), True, False),
    "identifiable.RATIO": (
        lambda: identifiability.of_ratios({"z_ba": 1e-3}, friction_law("elasto_plastic"))["z_ba"],
        *(0.03, 0.06),
    ),
    "identifiable.PRESLIDING": (lambda: with_least_error(0.03), 0.04, 0.08),
    "identifiable.QUANTISED": (lambda: with_least_error(0.02, 0.25), 0.0875, 0.175),
    "identifiable.BESIDE_FORCE": (
        lambda: identifiability.beside_force({"F_c": 1e-3}, {"F_c": 1.0})["F_c"],
        *(0.007, 0.014),
    ),
    "identifiable.STATIC": (lambda: with_least_error(0.01, name="F_s"), 0.02, 0.04),
    "identifiable.STRIBECK": (lambda: with_least_error(0.01, name="v_s"), 0.08, 0.16),
    "identifiable.SOFTEST": (lambda: taken("sigma_0", 4e5), 2e5, 4e5),
    "identifiable.BEYOND": (lambda: taken("F_s", 12.0), 8.0, 12.0),
    "stage.TRAVEL": (lambda: "200 encoder steps" in inertia(3e-5, 1.0), False, True),
    "stage.ENCODER_STEP": (lambda: inertia(1e-2, 6.0) == "", False, True),
    "stage.HELD": (lambda: fluctuates(0.3), True, False),
    "stage.SPEEDS_HELD": (lambda: held(6), True, False),
    "stage.RISE": (lambda: rises(0.03), True, False),
    "stage.POOR": (lambda: presliding_warning(0.3) != "", True, False),
    "stage.BREAKAWAY": (lambda: breaks_away(3e-3, 200), True, False),
    "stage.BREAKAWAY_SAMPLES": (lambda: breaks_away(5e-3, 30), True, False),
    "transfer.SAME": (lambda: in_common(1.015), False, True),
    "transfer.STRETCH": (lambda: in_common(samples=400), True, False),
    "transfer.MOVING": (lambda: same_command.is_moving(np.array([0.015, 1.0]))[0], True, False),
    "log_content.FEWEST": (lambda: on_grid(samples=30) == ["refused"], False, True),
    "log_content.DURATION": (lambda: is_short(1.5, 9000), False, True),
    "log_content.SAMPLES": (lambda: is_short(9.0, 700), False, True),
    "log_content.LONGEST": (lambda: is_cut(450_000, T_s=1e-4), True, False),
    "log_content.TOGETHER": (lambda: share_of_each(8), 0.25, 0.5),
    "agreement.CONTRADICTS": (lambda: contradicts(3.0), True, False),
    "agreement.MATTERS": (lambda: contradicts(3.0, share=0.03), True, False),
    "agreement.EXPLAINED": (lambda: contradicts(3.0, own=5.0), False, True),
    "agreement.DIFFERS": (lambda: differs(0.2), True, False),
    "agreement.CERTAIN": (lambda: is_own_offset(6.0), True, False),
    "log_content.MOST": (lambda: is_cut(150_000, T_s=1e-3), True, False),
    "log_content.TRAVEL": (lambda: is_short_travel(150), False, True),
    "log_content.MOVING": (lambda: shows(moving=0.15), 0, 1),
    "log_content.SLIDING": (lambda: is_rigid(70), True, False),
    "log_content.INERTIAL": (lambda: shows(inertial=0.07), 0, 1),
    "log_content.SLOW": (lambda: shows(slow=0.07), 0, 1),
    "log_content.SPEEDS": (lambda: shows(speeds=(1.0, 4.0)), 0, 1),
    "log_content.ONE_WAY": (lambda: one_way(0.015), False, True),
    "log_content.REVERSALS": (lambda: shows(reversals=3), 0, 1),
    "log_content.SPACING": (lambda: shows(spacing=30), 0, 1),
    "log_content.TURN": (lambda: shows(turn_around=TurnAround(1.0, 4.0, 4.0, 99)), 0, 1),
    "log_content.TURNS": (lambda: shows(turn_around=TurnAround(1.0, 9.0, 30.0, 5)), 0, 1),
    "log_delay.REPORTED": (lambda: motion.samples_late(rigid_drive(delay=3.0)), 3, 0),
    "log_delay.EXPLAINS/2": (lambda: motion.samples_late(rigid_log(delay=6.0)), 6, 0),
    "log_delay.KNOWN": (lambda: motion.Delay(0.0, 0.3).known(1.0), False, True),
    "log_force.LIMITED/2": (is_limited, True, False),
    "log_force.AT_LIMIT": (lambda: is_cut_off(0.008, spread=0.04), False, True),
    "log_force.PILED": (lambda: is_cut_off(0.008), True, False),
    "log_force.BEYOND": (lambda: is_cut_off(0.02, beyond=0.045), True, False),
    "log_force.EXACT/2": (is_low_passed, False, True),
    "log_force.LAGGED/2": (lambda: force_path._is_low_pass(0.3, 1.0, 1.0, 1.0), True, False),
    "log_force.LAGGED_ALIKE/2": (lambda: force_path._is_low_pass(0.3, 1.0, 0.5, 1.0), True, False),
    "log_force.ATTENUATED": (lambda: force_path._is_low_pass(0.1, 1.0, 1.0, 0.03), True, False),
    "log_force.AT_STATED/2": (lambda: saturates(6.0, 50), set(), {"saturates"}),
    "log_force.PLATEAU": (lambda: saturates(10.0, 4), {"saturates"}, set()),
    "log_force.DEMANDED": (lambda: saturates(10.0, 50, 10.7), {"saturates"}, set()),
    "log_force.SELDOM": (lambda: saturates(10.0, 12, 20.0, None), {"saturates"}, set()),
    "log_force.EXCEEDED": (lambda: "exceeds" in saturates(12.0, 50), True, False),
    "log_force.LOST_ROWS": (lambda: lost(7), True, False),
    "log_jump.FAR": (lambda: jump(1.5, 0.05), True, False),
    "log_jump.STANDS_OUT": (lambda: jump(3.0, 0.2), True, False),
    "log_jump.BACK": (
        lambda: grid._lost(np.array([5, 7]), np.array([1.0, -0.85]), np.zeros(2))[0].size,
        0,
        2,
    ),
    "log_jump.EQUAL": (lambda: restart(5.0, 5.15) is not None, False, True),
    "log_jump.FEWEST": (lambda: restart(5.0, 5.0, 5.0) is not None, True, False),
    "log_unit.IMAGE": (lambda: contradicting(ratio=5.0, other="velocity"), ["warning"], []),
    "log_unit.SURE_IMAGE": (lambda: contradicting(2.0 * np.pi, 0.99), ["error"], []),
    "log_unit.SMALL": (lambda: contradicting(ratio=25.4), ["error"], []),
    "log_unit.UNLIKE": (lambda: contradicting(high=0.5), [], ["error"]),
    "log_unit.SHARED": (lambda: contradicting(shared=0.15), [], ["error"]),
    "log_unit.MOVING": (lambda: shared(0.15), True, False),
    "log_unit.FOLLOWS": (lambda: contradicting(ratio=3.0, high=0.99), ["warning"], []),
    "log_unit.EQUALS": (lambda: contradicting(2.0, other="velocity"), ["warning"], []),
    "log_unit.NEAR": (lambda: units.near_factor(25.4 * 1.05) is None, True, False),
    "log_unit.ROUGHLY": (lambda: units.near_factor(1.45e6) is None, True, False),
    "log_unit.FASTER": (lambda: contradicting(T_s=1e-3 / 300.0), ["error"], []),
    "log_unit.SLOWER": (lambda: contradicting(T_s=0.03), ["error"], []),
    "log_unit.SLOWEST": (lambda: is_slow(0.08), True, False),
    "log_unit.STEP": (lambda: other_steps(1.07), True, False),
    "log_clock.FILLED": (lambda: "warning" in on_grid(gap=8), True, False),
    "log_clock.EVEN": (lambda: on_grid(jitter=0.015), ["note"], []),
    "log_clock.UNEVEN": (lambda: on_grid(jitter=0.15), ["warning"], ["note"]),
    "log_clock.ROUNDED": (lambda: is_rounded(1.0), False, True),
    "log_clock.STILL": (lambda: is_refused(0.35), False, True),
    "log_clock.IN_TURN": (lambda: in_turn(1.0 / 4.0), True, False),
    "kept.FIT_WORSE": (lambda: refined(1.5), "start", "refined"),
    "kept.LOOP_WORSE": (lambda: taken_loop(1.03), "reference", "learned"),
    "kept.LOOP_BETTER/2": (lambda: taken_loop(1.0), "learned", "reference"),
    "kept.ENDED/2": (lambda: is_unfinished(pd.DataFrame({"cost": [1.0, 1.0, 0.9]})), True, False),
    "kept.SENSITIVITY": (lambda: is_run(2.5), False, True),
    "kept.CHATTER": (lambda: is_within(chatter=0.45), False, True),
    "kept.FORCE/2": (lambda: is_within(peak=0.7), True, False),
    "kept.ERRS_ALIKE": (lambda: bool(models({"lugre": 0.15})[1]), True, False),
    "kept.ERRS_WELL": (lambda: models({"lugre": 0.15}, {"lugre": 0.07})[1]["lugre"], 300, 60),
    "kept.HOPELESS": (lambda: "gms" in models({"lugre": 0.2, "gms": 0.6})[1], False, True),
    "kept.FURTHER": (lambda: models({"lugre": 0.2, "gms": 0.3})[0], ["lugre"], ["lugre", "gms"]),
    "rig_tuning.WORSE": (lambda: goes_on(ratio=1.5), False, True),
    "rig_tuning.RIPPLE": (lambda: goes_on(ripple=3.0), False, True),
    "rig_motion.SPACING": (lambda: is_refused_log(0.015), True, False),
    "rig_motion.RETURNED": (lambda: returns(3e-5), False, True),
    "rig_motion.STALL": (lambda: is_stopped(15.0), True, False),
    "rig_motion.AT_REST": (lambda: braked(v=1.5e-3), "stopping", "idle"),
    "rig_motion.SETTLED": (lambda: braked(resting=0.15), "idle", "stopping"),
    "rig_motion.LONGEST_STOP": (lambda: braked(1.0, stopping=4.0), "idle", "stopping"),
    "experiment.DURATION": (lambda: is_planned(duration=3.0), True, False),
    "experiment.SLOWEST": (lambda: is_planned(rate=150.0), True, False),
    "experiment.FASTEST/2": (lambda: is_planned(rate=8e4), True, False),
    "experiment.SAMPLES/2": (lambda: is_planned(duration=300.0, rate=5e4), True, False),
    "experiment.RISE": (lambda: least_shown(friction=8.0, K_i=8e3), 2.0, 4.1),
    "experiment.STICKS": (lambda: least_shown(friction=8.0, K_p=1e3), 1.6, 3.2),
    "experiment.STEPS": (lambda: least_shown(encoder=1e-4), 4.1, 8.2),
}


@pytest.mark.parametrize("name", CASES)
def test_a_threshold_decides(name, monkeypatch):
    decide, before, after = CASES[name]
    assert decide() == before
    name, _, half = name.partition("/")
    factor = 0.5 if half else 2.0
    monkeypatch.setattr(f"{thresholds.__name__}.{name}", factor * NAMES[name][0])
    assert decide() == after


def test_every_threshold_has_a_case_and_a_meaning():
    assert {name.partition("/")[0] for name in CASES} == set(NAMES)
    assert all(text for _, text in NAMES.values())


def test_code_reads_thresholds_when_it_decides():
    """None is a constant beside the code, a default argument or unused."""
    used, rooms = set(), "|".join(MODULES)
    for path in (ROOT / "stickslip").rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        for room, name in re.findall(rf"\b({rooms})\.([A-Z_]+)\b", text):
            used.add(f"{room}.{name}")
            assert not re.search(rf"^{name}\b.* = ", text, re.MULTILINE), (path, name)
        assert "from stickslip.thresholds." not in text, path
        assert not re.search(rf": [\w.| ]+ = (?:{rooms})\.[A-Z_]+[,)]", text), path
    assert used >= set(NAMES)


def test_evidence_is_there():
    """Pages and decisions that a threshold rests on exist."""
    numbers = {int(path.name[:4]) for path in (ROOT / "docs/decisions").glob("0*.md")}
    for name, (value, _) in NAMES.items():
        for number in re.findall(r"decision (\d+)", value.evidence):
            assert int(number) in numbers, name
        for path in re.findall(r"\S+/\S+\.\w+", value.evidence):
            assert (ROOT / path).is_file(), name
