"""Experiments that show a drive's parameters in one recording, as velocity commands."""

from stickslip.plan.experiment import (
    Stretch,
    arrange,
    plan,
)
from stickslip.plan.limits import (
    LINEAR,
    ROTARY,
    Limits,
)
from stickslip.plan.picture import draw_plan

__all__ = ["LINEAR", "ROTARY", "Limits", "Stretch", "arrange", "draw_plan", "plan"]
