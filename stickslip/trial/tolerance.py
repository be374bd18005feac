"""Over-compensation: how much too large the force may be, and how well it is known."""

from __future__ import annotations

from collections.abc import Mapping

from stickslip.catalog.space import ParameterSpace
from stickslip.thresholds import caution
from stickslip.trial.single_run import Finding, Run, Trial

MOST = 1.0  # share at which the search ends: twice the friction is as wrong as none
_BOUND = 1.96  # standard errors to a bound of the 95 % interval


def tolerance(trial: Trial, standard_errors: Mapping[str, float]) -> list[Finding]:
    """Return findings on forces that are too large, and on parameters at their 95 % bounds.

    Parameters
    ----------
    standard_errors : of the compensator's parameters, in their units; those missing count as known
    """
    with trial.runs(compensated=False) as run:
        without = run.error()
    with trial.runs(compensated=True) as run:
        return [*_too_large(run, without), *_at_bounds(run, without, standard_errors)]


def tolerated(run: Run, without: float) -> float:
    """Return the share by which friction may be too large before the error is that of none."""
    low, high = 0.0, MOST
    if run.error() >= without:
        return 0.0
    if _scaled(run, high) < without:
        return high
    while high - low > 0.02:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _scaled(run, middle) < without else (low, middle)
    return low


def _scaled(run: Run, share: float) -> float:
    p, law = run.trial.compensator, run.trial.law
    levels = [name for name, one in law.parameters.items() if one.unit == "N"]
    return run.error({name: (1.0 + share) * p[name] for name in levels})


def _too_large(run: Run, without: float) -> list[Finding]:
    share = tolerated(run, without)
    if share >= caution.TOO_LARGE:
        return []
    force = f"a force {100 * share:.0f} % too large" if share else "this force"
    message = (
        f"{force} makes the tracking error at least as large as without a"
        f" compensator, {_speed(run, without)}; expected {100 * caution.TOO_LARGE:g} % or more;"
        " raise K_p, or do not compensate on this command"
    )
    return [Finding("over-compensation", share, caution.TOO_LARGE, "1", message=message)]


def _at_bounds(run: Run, without: float, errors: Mapping[str, float]) -> list[Finding]:
    p, bounded = run.trial.compensator, ParameterSpace.of(run.trial.law).bounded
    worst, case = 0.0, ""
    for name, error in errors.items():
        for sign in (1.0, -1.0):
            value = max(p[name] + sign * _BOUND * error, 1e-3 * p[name])
            changed = {**p, name: value}
            for one, bound in bounded.items():
                changed[one] = max(changed[one], changed[bound])
            found = run.error(changed)
            if found > worst:
                worst, case = found, f"{name} = {value:.4g}"
    if worst <= without or run.error() >= without:
        return []
    message = (
        f"with {case}, a bound of its 95 % interval, the tracking error is {_speed(run, worst)};"
        f" expected at most that without a compensator, {_speed(run, without)}; learn from a"
        " recording that shows this parameter better"
    )
    return [
        Finding("uncertainty", worst, without, run.trial.loop.axis.unit("m/s"), message=message)
    ]


def _speed(run: Run, error: float) -> str:
    return f"{1e3 * error:.3g} {run.trial.loop.axis.unit('mm/s')}"
