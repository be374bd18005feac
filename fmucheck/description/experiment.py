"""Rules about the default experiment."""

from __future__ import annotations

import math

from stickslip.fmucheck.description.model import Description
from stickslip.fmucheck.description.values import Number, number
from stickslip.fmucheck.finding import Severity
from stickslip.fmucheck.rules import Claims, rule

_PLACE = "DefaultExperiment"


def experiment_number(description: Description, name: str) -> Number | None:
    """Return an attribute of the default experiment."""
    return number((description.experiment or {}).get(name))


@rule(Severity.ERROR, fmi2="2.2.5", fmi3="2.4.6", advice="stop after the start")
def stop_before_start(description: Description) -> Claims:
    """The stopTime is not after startTime."""
    start = experiment_number(description, "startTime") or 0.0
    stop = experiment_number(description, "stopTime")
    if stop is not None and stop <= start:
        yield _PLACE, f"stopTime {stop} is not after startTime {start}"


@rule(Severity.ERROR, fmi2="2.2.5", fmi3="2.4.6", advice="write a finite time")
def time_not_finite(description: Description) -> Claims:
    """A time is infinite or not a number, on which importers run for ever."""
    for name in ("startTime", "stopTime"):
        value = experiment_number(description, name)
        if value is not None and not math.isfinite(value):
            yield _PLACE, f"{name} {value}"


@rule(Severity.ERROR, fmi2="2.2.5", fmi3="2.4.6", advice="write a step above 0")
def bad_step_size(description: Description) -> Claims:
    """A step size is 0, negative or not finite."""
    steps = [(_PLACE, "stepSize", experiment_number(description, "stepSize"))]
    for interface in description.interfaces:
        fixed = number(interface.given.get("fixedInternalStepSize"))
        steps.append((interface.place, "fixedInternalStepSize", fixed))
    for place, name, step in steps:
        if step is not None and not (step > 0.0 and math.isfinite(step)):
            yield place, f"{name} {step}"


@rule(Severity.WARNING, fmi2="2.2.5", fmi3="2.4.6", advice="make the step smaller")
def step_beyond_stop(description: Description) -> Claims:
    """One step is longer than the whole experiment."""
    start = experiment_number(description, "startTime") or 0.0
    stop, step = (experiment_number(description, name) for name in ("stopTime", "stepSize"))
    if stop is not None and step is not None and start < stop < start + step:
        yield _PLACE, f"stepSize {step} for {start} .. {stop}"


@rule(Severity.ERROR, fmi2="2.2.5", fmi3="2.4.6", advice="write a relative tolerance such as 1e-6")
def bad_tolerance(description: Description) -> Claims:
    """The tolerance is 0, negative or not finite."""
    tolerance = experiment_number(description, "tolerance")
    if tolerance is not None and not (tolerance > 0.0 and math.isfinite(tolerance)):
        yield _PLACE, f"tolerance {tolerance}"


@rule(Severity.NOTE, fmi2="2.2.5", fmi3="2.4.6", advice="propose stopTime and stepSize")
def no_default_experiment(description: Description) -> Claims:
    """No experiment is proposed, so that users have to guess how long to simulate."""
    if description.experiment is None:
        yield "modelDescription.xml", f"there is no {_PLACE}"
