"""The choice of a criterion: the one that the recording allows, with the reason."""

from __future__ import annotations

import numpy as np

from stickslip.catalog.parameters import friction_law
from stickslip.errors import UsageError
from stickslip.identification.controller.controller_check import ControllerCheck
from stickslip.identification.controller.initial_state import is_running
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.output_error import OutputError
from stickslip.identification.estimation.task import Task
from stickslip.thresholds import control_match


def choose(task: Task, check: ControllerCheck | None) -> tuple[str, str]:
    """Return the criterion and why."""
    loop, inverse = OutputError.name, InverseModel.name
    if task.settings.criterion == loop and check is None:
        raise UsageError(
            "the output error needs the controller that made the log: give its gains, "
            "or use the inverse model as the criterion"
        )
    if task.settings.criterion != "auto":
        return task.settings.criterion, "asked for"
    if task.recording.friction is not None and task.recording.force is None:
        return inverse, "friction itself was measured"
    law = friction_law(task.settings.law)
    if not law.is_smooth and task.recording.force is not None:
        return inverse, (
            f"the law {law.title} switches, so that a simulated loop does not follow small changes "
            "of its parameters smoothly"
        )
    if check is None:
        return inverse, "the controller is not known, so the loop cannot be run again"
    if np.isnan(check.error):
        return loop, "the controller is known and no force was logged"
    if check.error > control_match.EXACT:
        return inverse, (
            f"the controller given commands a force that differs by {100 * check.error:.2g} % from "
            "the one logged, so the loop is not known well enough to run it again"
        )
    form = f", its {check.form}" if check.form else ""
    running = " and was running when the log began" if is_running(check.gains) else ""
    return loop, (
        f"the controller is known{form}{running}, and commands the logged force within "
        f"{100 * check.error:.2g} %"
    )
