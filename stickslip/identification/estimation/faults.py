"""Faults of a recording that the estimation finds; no parameter is then well identified."""

from __future__ import annotations

from collections.abc import Iterator

from stickslip.identification.controller.controller_check import ControllerCheck
from stickslip.identification.criteria.output_error import OutputError
from stickslip.identification.fitting.fit import Fit
from stickslip.logs import Finding

MODEL_ERROR = 2.0
"""Largest ratio of the loop's residual to that from encoder and noise."""
NEAR = 0.01
"""Distance from a bound of the delay that counts as none [samples]."""


def found_faults(
    fitted: Fit, criterion: str, check: ControllerCheck | None, model_error: float = 0.0
) -> Iterator[Finding]:
    """Yield each fault, with its figure and what to do.

    Parameters
    ----------
    fitted : by the criterion of that name
    check : of the controller; None where it is not known
    model_error : residual of the loop over that from encoder and noise
    """
    u = fitted.space
    index = u.index("delay")
    delay, low, high = (float(q[index]) for q in (fitted.q, u.lower, u.upper))
    at_low = delay - low < NEAR and criterion != OutputError.name  # no lag is a drive without one
    if at_low or high - delay < NEAR:
        figure = f"{delay:.3g} samples or {1e3 * delay * u.units[index]:.3g} ms"
        advice = "log force and position of the same instants, or shift the force by its delay"
        what = "the delay of the force ends at the bound of the fit"
        yield Finding("warning", what, figure, advice, spoils="intervals")
    law = u.law
    if criterion == OutputError.name and not law.is_smooth and model_error > MODEL_ERROR:
        what = f"the simulated loop with the law {law.title} does not follow the recording"
        figure = f"its residual is {model_error:.2g} times what encoder and noise explain"
        yield Finding("warning", what, figure, "take the values as coarse", spoils="intervals")
    if check is not None and check.factor != 1.0:
        what = "the logged force is out of scale with the force that the controller commands"
        figure = f"{check.factor:.3g} times as large"
        advice = f"give --scale force={1.0 / check.factor:.3g}, or correct its unit or the gains"
        yield Finding("warning", what, figure, advice, spoils="values")
