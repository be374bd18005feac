"""What changes when a threshold is doubled or halved, for each of them."""

from __future__ import annotations

import importlib
import pkgutil
import re
import sys
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest

from stickslip import cosim, thresholds
from stickslip.catalog.parameters import friction_law
from stickslip.catalog.space import ParameterSpace
from stickslip.errors import IdentificationError
from stickslip.identification import estimation
from stickslip.identification.controller import controller_check, criterion_choice
from stickslip.identification.controller.controller_check import ControllerCheck
from stickslip.identification.criteria import surrogate_controller
from stickslip.identification.fitting import identifiability, multistart
from stickslip.identification.fitting.conservative import conservative
from stickslip.identification.fitting.identifiability import NOT_IDENTIFIABLE, Identifiability
from stickslip.identification.selection import choose, folds, mismatch, prediction
from stickslip.identification.sliding import friction_curve
from stickslip.identification.stages import friction_map, presliding, sliding
from stickslip.identification.stages.inertia import measure_inertia
from stickslip.logs import Recording
from stickslip.servo import observer
from stickslip.servo.axis import Axis, ControlError
from stickslip.servo.datasheet import LOOP
from stickslip.servo.velocity_loop import close_velocity_loop, design_velocity_loop
from stickslip.studies.learn import log_learning
from stickslip.studies.validate import compared_logs, log_prediction, log_verdict
from stickslip.trial import compensator_trial, tolerance
from stickslip.trial.benefit import NONE, TrialError, _repeated
from stickslip.trial.candidates import CompensatorComparison, Row
from stickslip.trial.guards import Hold, Trial, hunting, hunting_at_rest, stribeck
from tests.stickslip.identification.synthetic_predictions import predicted

ROOT = Path(thresholds.__file__).parents[2]
MODULES = {
    one.name: importlib.import_module(f"{thresholds.__name__}.{one.name}")
    for one in pkgutil.iter_modules(thresholds.__path__)
}
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
    "F_s": 9.0,
    "F_c": 6.0,
    "v_s": 5.57e-4,
    "sigma_0": 3.9e5,
    "sigma_1": 4.4e3,
    "delta": 1.0,
}
T_S = 5e-4


def namespace(**values: Any) -> Any:
    return SimpleNamespace(**values)


def raises(call, *errors):
    """Return whether a call raises one of some errors."""
    try:
        call()
    except errors:
        return True
    return False


def is_repeated(ratio):
    """Return whether the mean of several runs replaces one run with this ratio of errors."""
    rows = (TrialError(1.0, "", 1.0, ratio),)
    return _repeated(rows, lambda: (1.0,), lambda: (9.0,))[0].compensated == 9.0


def rivals():
    """Return the laws that a log with a force error of 1 N, and 3 N of GMS, does not rule out."""
    found = [replace(predicted(law, error), parameters=FRICTION) for law, error in RIVALS]
    fitted = namespace(largest_friction=9.0, plausible=())
    known = {
        name: namespace(value=1.0, low=0.9, high=1.1, identifiability="identifiable")
        for name in SPACE.friction
    }
    drive = namespace(fit=namespace(space=SPACE), known=known, law=SPACE.law, fitted=fitted)
    drive.held_out = namespace(predictions=found)
    return set(compensator_trial.known_friction(drive).rivals)


SPACE = ParameterSpace.of(friction_law())
RIVALS = (("lugre", 1.0), ("coulomb_stribeck", 3.0))


def is_growing():
    """Return whether a weak loop in slow motion is warned of; a deviation grows by e^5.5."""
    command = cosim.Trapezoid(height=1e-3, slope=0.02, plateau=0.02, begin=0.1)
    v_cmd = command.sample(np.arange(0.32 / T_S) * T_S)
    loop = close_velocity_loop(AXIS, T_S, T_S, 500.0, 1e4)
    return bool(stribeck(Trial(Path(), loop, FRICTION, FRICTION, v_cmd)))


@dataclass(frozen=True)
class Swinging(Trial):
    """A loop whose velocity swings, whatever its command."""

    swing: float = 0.0

    @contextmanager
    def runs(self, **_):
        """Yield the run."""
        wave = 0.5 * self.swing * np.sin(np.arange(len(self.v_cmd)))
        yield namespace(velocity=lambda: wave)


def is_hunting(v_cmd, swing):
    """Return whether a swing of the velocity [m/s] is warned of, on an axis without v_s."""
    trial = Swinging(Path(), design_velocity_loop(AXIS, LOOP), {}, {}, np.array(v_cmd), swing=swing)
    return bool(hunting(trial))


def is_too_large(most):
    """Return whether a loop is warned of that forces up to ``most`` too large make better."""
    trial = namespace(law=friction_law(), compensator=FRICTION, loop=namespace(axis=AXIS))
    scaled = lambda values=FRICTION: 0.5 if values["F_c"] < (1.0 + most) * 6.0 else 2.0  # noqa: E731
    return bool(tolerance._too_large(namespace(trial=trial, error=scaled), 1.0))


def is_at_rest(swing, reversals):
    """Return whether a swing at rest, in encoder steps, is warned of."""
    found = {NONE.name: Hold(swing, reversals, 1.0, "any")}
    return bool(hunting_at_rest(found, NONE, 1.0))


def chosen(mean):
    """Return which is recommended: static feedforward, or what leaves ``mean`` times its error."""
    rows = [
        Row(name, k, 1.5, namespace(mean_ratio=error, acceptable=True))
        for k, (name, error) in enumerate({"static": 0.5, "observer": 0.5 * mean}.items())
    ]
    return CompensatorComparison(tuple(rows)).chosen.name


def designed(reversal, **limits):
    """Return the basis on which an observer is designed, which leaves a share of the error."""

    def best(search, start):
        basis = "reversals" if search.loudest else "whole error"
        return start._replace(observer=True, weights=basis, reversal=reversal * start.reversal)

    with patch.object(observer._Search, "best", best):
        try:
            loop = design_velocity_loop(AXIS, LOOP)
            return observer.design_observer(loop, 1e-6, 6.0, **limits).weights
        except ControlError:
            return None


def checked(error, factor=1.0):
    return ControllerCheck(np.zeros(1), error, 0, {}, factor=factor)


def criterion(error):
    """Return how a log is fitted whose controller commands the force with this error."""
    task = namespace(
        settings=namespace(criterion="auto", law="lugre"),
        recording=namespace(friction=None, force=True),
    )
    return criterion_choice.choose(task, checked(error))[0]


def is_foreign(error):
    """Return whether a rig's log whose controller differs is warned of."""
    scale = namespace(recording=lambda one: one, values=lambda one: one)
    reading = namespace(controller=namespace(parameters=dict), recording=None)
    with patch.multiple(
        log_learning,
        recording_scale=lambda _: scale,
        against_motion=lambda one: (one, ()),
        candidate_fmus=nullcontext,
        check_controller=lambda *_: checked(error),
    ):
        return bool(list(log_learning.check_rig(reading)))


def scale_of_force(noise):
    """Return the factor found between logged and commanded force, with noise beside it."""
    force, rest = np.sin(0.01 * np.arange(5000)), np.cos(0.01 * np.arange(5000))
    found = replace(checked(0.9), force=force)
    return controller_check._factor(2.0 * force + 2.0 * noise * rest, T_S, found)


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
    stretch = compared_logs.Stretch(0, 0, len(command))
    return compared_logs._parts(command, [stretch], 1e-3)[1]


def faults(delay=5.0, change=(0.0, 0.1)):
    """Return what is found wrong with a fit by its delay [samples] and a change of friction."""
    ends = {"lower": np.array([-5.0]), "upper": np.array([20.0]), "units": np.array([T_S])}
    space = namespace(index=lambda _: 0, law=SPACE.law, **ends)
    fitted = namespace(space=space, q=np.array([delay]))
    found = estimation.faults.found_faults(fitted, "inverse model", None, np.nan, change)
    return [one.what.partition(" of")[0] for one in found]


def is_coarse(step):
    """Return whether an encoder whose step is a share of the motion in a sample is coarse."""
    inverse = namespace(motion=namespace(v=np.ones(9)), T_s=T_S)
    return surrogate_controller.coarse(inverse, namespace(encoder_step=step * T_S))


def curve():
    """Return the forces beside a law that sliding shows, with ripple of 9 standard errors.

    It is None for a motion that gives no curve.
    """
    estimate = np.ones(4), np.ones(4), np.array([9.0, 0.0, 0.0]), np.ones(3)
    x = np.sin(np.linspace(0.0, 30.0, 4000))
    with (
        patch.object(friction_curve._Rows, "estimate", lambda *_: estimate),
        patch.object(friction_curve._Rows, "speeds", lambda *_: np.ones(1)),
    ):
        found = friction_curve.friction_curve(x, x, T_S, 1e-6)
    return found and set(found.varying)


def not_explained(apart=0.0, varying=0.0, **_):
    """Return whether the force decides instead of the simulated loop."""
    shown = namespace(value=np.ones(1), varying={"ripple": varying})
    start = namespace(disagreement=lambda _: apart, curve=shown)
    corrected = namespace(model_error=1.0, fit=namespace(parameters={}))
    return bool(estimation_learn._not_explained(corrected, start))


def is_less(gain, spread):
    """Return whether squared errors that vary by block are less by a share of the others."""
    sign = np.resize([1.0, -1.0], 40)
    return folds.is_less(np.exp(spread * sign - gain), np.ones(40))


def law(error):
    """Return the law that is chosen for its error over Coulomb's, with no parameter identified."""
    plain = predicted("coulomb_stribeck", 1.0, is_level=True)
    return choose([plain, predicted("gms", error, shown=())]).chosen.candidate.law.name


def seen(rise):
    """Return what a fit shows of the Stribeck curve, whose rise is so many standard errors."""
    fitted = namespace(space=SPACE, errors=dict, q=np.full(len(SPACE.names), rise))
    fitted.covariance = np.eye(len(SPACE.names))
    with patch.object(prediction, "identifiability", lambda *_: namespace(identifiability="")):
        return "v_s" in prediction._shown(fitted)


def fits(noise):
    """Return two fits by their mean square, 1 of the first."""
    space = namespace(names=("F_c",))
    return [
        namespace(noise=one, q=np.zeros(1), covariance=np.eye(1), space=space)
        for one in (1.0, noise)
    ]


def flat(noise):
    """Return whether a rise towards rest is left out, at the cost of a larger mean square."""
    found = namespace(errors=dict, space=SPACE, noise=1.0, q=np.ones(len(SPACE.names)))
    hidden = namespace(identifiability=NOT_IDENTIFIABLE)
    with patch.multiple(
        multistart, identifiability=lambda *_: hidden, fit=lambda *_: namespace(noise=noise)
    ):
        return multistart.without_stribeck(namespace(over=id), found) is not found


def unexplained(error, explained, **changes):
    """Return the prediction of a law with an error [N], of which noise explains a part."""
    return replace(predicted("lugre", error), explained=explained, **changes)


def warning(found, *causes):
    """Return the finding that a law does not explain a log."""
    (one,) = mismatch.mismatch(found, [], causes, rotary=False)
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


def taken(name, value):
    """Return what the compensator takes of a value; the largest force in the log is 8 N."""
    levels = {"F_s": "weakly identifiable", "sigma_0": NOT_IDENTIFIABLE}
    known = {
        one: Identifiability(at, 0.0, 0.0, 9.0 * at, levels.get(one, "identifiable"), "")
        for one, at in {**FRICTION, name: value}.items()
    }
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
    with patch.object(sliding, "_forth_and_back", side_effect=runs):
        return not raises(lambda: sliding.measure_sliding(None, None), IdentificationError)


def fluctuates(share):
    """Return whether a speed counts as held whose velocity fluctuates by a share of it."""
    v = np.where((np.arange(12000) < 500) | (np.arange(12000) >= 6500), -0.04, 0.04)
    wave = 1.0 + np.sqrt(2.0) * share * np.sin(2.0 * np.pi * 5.0 * T_S * np.arange(12000))
    loop = namespace(axis=AXIS)
    return sliding._forth_and_back(rig(None, v * wave), loop, 0.04) is None


def rises(share):
    """Return whether friction that rises towards rest by a share gives v_s."""
    speed = np.geomspace(1e-3, 0.04, 12)
    force = 6.0 * (1.0 + share * np.exp(-speed / 4e-3))
    shown = sliding.Sliding(speed, force, -force, force, 1e-4 * force, np.ones(9), 1e-9)
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
    return presliding._evaluated(fit, np.ones(1), left)[2]


CASES: dict[str, tuple[float, Any, object, object]] = {
    # threshold: factor on it, decision, verdict before and after
    "harm.WORSE": (2.0, lambda: TrialError(1.0, "", 1.0, 1.2).is_worse, True, False),
    "harm.REPEATED_ABOVE": (2.0, lambda: is_repeated(1.0), True, False),
    "harm.REPEATED_BELOW": (0.5, lambda: is_repeated(1.0), True, False),
    "harm.RULED_OUT": (0.5, rivals, {"coulomb_stribeck"}, set()),
    "caution.GROWTH": (2.0, is_growing, True, False),
    "caution.TOO_LARGE": (2.0, lambda: is_too_large(0.3), False, True),
    "caution.PLATEAU": (2.0, lambda: is_hunting([0.0] * 800 + [10.0], 0.5), True, False),
    "caution.STANDING": (2.0, lambda: is_hunting([0.1] * 9 + [0.0], 1.5e-3), True, False),
    "caution.SWING": (2.0, lambda: is_at_rest(3.0, 2), True, False),
    "caution.REVERSALS": (2.0, lambda: is_at_rest(3.0, 2), True, False),
    "offer.SIMPLER": (2.0, lambda: chosen(0.92), "observer", "static"),
    "offer.SENSITIVITY": (0.5, lambda: designed(0.5), "whole error", None),
    "offer.WORTHWHILE": (0.5, lambda: designed(0.6), "whole error", None),
    "offer.HIDDEN": (0.5, lambda: designed(0.5), "whole error", "reversals"),
    "control_match.EXACT": (2.0, lambda: criterion(0.015), "inverse model", "output error"),
    "control_match.NEAR": (
        *(2.0, lambda: "controller differs" in verdict(controller=checked(0.07))),
        *(True, False),
    ),
    "control_match.FOREIGN": (2.0, lambda: is_foreign(0.5), True, False),
    "control_match.OUT_OF_SCALE": (0.5, lambda: scale_of_force(0.07) > 1.9, True, False),
    "control_match.OTHER_FORM": (
        0.5,
        lambda: controller_check._believed(checked(1.0), checked(0.3)).error,
        *(0.3, 1.0),
    ),
    "control_match.GAINS_SHOWN": (0.5, lambda: shows_gains(0.3), False, True),
    "transfer.SMALL": (2.0, lambda: "within" in verdict(relative=0.08), False, True),
    "transfer.MASS": (2.0, lambda: changed("m", 0.03), True, False),
    "transfer.VISCOUS": (2.0, lambda: changed("b", 7.0), True, False),
    "transfer.FRICTION": (2.0, lambda: changed("friction", 0.03), True, False),
    "transfer.OFFSET": (2.0, lambda: changed("F_0", 0.3), True, False),
    "transfer.INTERVAL": (2.0, lambda: explained(0.2), False, True),
    "transfer.IN_COMMON": (2.0, lambda: raises(lambda: compared(0.3), Exception), False, True),
    "transfer.REPETITIONS": (2.0, lambda: parts(4), True, False),
    "loop_fit.MODEL_ERROR": (2.0, lambda: "drive holds" in verdict(ratio=3.0), False, True),
    "loop_fit.DELAY_AT_BOUND": (2.0, lambda: faults(delay=-4.985), [], ["the delay"]),
    "loop_fit.CHANGE": (2.0, lambda: len(faults(change=(0.05, 0.001))), 1, 0),
    "loop_fit.CHANGE_CERTAIN": (2.0, lambda: len(faults(change=(0.05, 0.008))), 1, 0),
    "loop_fit.COARSE": (2.0, lambda: is_coarse(0.007), True, False),
    "loop_fit.ALIKE": (2.0, lambda: surrogate_controller.is_alike(3.0), False, True),
    "curve_shown.ROWS": (2.0, curve, {"ripple"}, None),
    "curve_shown.CERTAIN": (2.0, curve, {"ripple"}, set()),
    "curve_shown.VARIES": (2.0, lambda: not_explained(varying=0.007), True, False),
    "curve_shown.CONTRADICTED": (2.0, lambda: not_explained(apart=2.0), True, False),
    "law_choice.TIE": (2.0, lambda: is_less(0.1, 0.2), True, False),
    "law_choice.MARGIN": (0.5, lambda: is_less(0.4, 0.0), True, False),
    "law_choice.UNIDENTIFIED": (0.5, lambda: law(0.5), "gms", "coulomb_stribeck"),
    "law_choice.RISES": (2.0, lambda: seen(3.0), True, False),
    "law_choice.RISE_WORTH": (2.0, lambda: flat(1.5), False, True),
    "law_choice.EXPONENT": (0.5, lambda: multistart.select(fits(0.9)).fit.noise, 0.9, 1.0),
    "misfit.NOTED": (2.0, lambda: mismatch.is_mismatch(unexplained(0.25, 0.1)), True, False),
    "misfit.SPOILED": (2.0, lambda: warning(unexplained(0.3, 0.1)).spoils, "intervals", ""),
    "misfit.SMALLEST": (2.0, lambda: mismatch.is_mismatch(unexplained(0.2, 0.1)), True, False),
    "misfit.BEATEN": (
        *(0.5, lambda: mismatch.is_beaten(unexplained(1.0, 1.0), [predicted("gms", 0.5)])),
        *(True, False),
    ),
    "misfit.LARGE": (2.0, lambda: mismatch.is_large(unexplained(0.9, 0.9)), True, False),
    "misfit.LIKELY": (
        *(2.0, lambda: warning(unexplained(1.0, 0.1), mismatch.Cause("", 0.6, "advice")).advice),
        *("advice", "take the values as coarse"),
    ),
    "identifiable.WELL": (2.0, lambda: level(0.08), "weakly identifiable", "identifiable"),
    "identifiable.WEAKLY": (2.0, lambda: level(0.4), NOT_IDENTIFIABLE, "weakly identifiable"),
    "identifiable.PRIOR_DOMINATED": (2.0, lambda: is_prior(0.7), True, False),
    "identifiable.SOFTEST": (2.0, lambda: taken("sigma_0", 4e5), 2e5, 4e5),
    "identifiable.BEYOND": (2.0, lambda: taken("F_s", 12.0), 8.0, 12.0),
    "stage.TRAVEL": (2.0, lambda: "200 encoder steps" in inertia(3e-5, 1.0), False, True),
    "stage.ENCODER_STEP": (2.0, lambda: inertia(1e-2, 6.0) == "", False, True),
    "stage.HELD": (2.0, lambda: fluctuates(0.3), True, False),
    "stage.SPEEDS_HELD": (2.0, lambda: held(6), True, False),
    "stage.RISE": (2.0, lambda: rises(0.03), True, False),
    "stage.POOR": (2.0, lambda: presliding_warning(0.3) != "", True, False),
    "stage.BREAKAWAY": (2.0, lambda: breaks_away(3e-3, 200), True, False),
    "stage.BREAKAWAY_SAMPLES": (2.0, lambda: breaks_away(5e-3, 30), True, False),
}


@pytest.mark.parametrize("name", CASES)
def test_a_threshold_decides(name, monkeypatch):
    factor, decide, before, after = CASES[name]
    assert decide() == before
    monkeypatch.setattr(f"{thresholds.__name__}.{name}", factor * NAMES[name][0])
    assert decide() == after


def test_every_threshold_has_a_case_and_a_meaning():
    assert set(CASES) == set(NAMES)
    assert all(text for _, text in NAMES.values())


def test_no_other_module_defines_a_threshold():
    """A name of a threshold that code reads through its module is no constant beside that code."""
    for path in (ROOT / "stickslip").rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        for name in re.findall(rf"\b(?:{'|'.join(MODULES)})\.([A-Z_]+)\b", text):
            assert not re.search(rf"^{name}\b.* = ", text, re.MULTILINE), (path, name)


def test_evidence_is_there():
    """Pages and decisions that a threshold rests on exist."""
    numbers = {int(path.name[:4]) for path in (ROOT / "docs/decisions").glob("0*.md")}
    for name, (value, _) in NAMES.items():
        for number in re.findall(r"decision (\d+)", value.evidence):
            assert int(number) in numbers, name
        for path in re.findall(r"\S+/\S+\.\w+", value.evidence):
            assert (ROOT / path).is_file(), name
