"""Experiments that show a drive's parameters in one recording, as velocity commands."""

from stickslip.planning.experiment import SET, Stretch, arrange, plan
from stickslip.planning.parts import LINEAR, ROTARY, Limits

__all__ = ["LINEAR", "ROTARY", "SET", "Limits", "Stretch", "arrange", "plan"]
