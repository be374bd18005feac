"""Rigs: real or simulated drives that run commands and return logs."""

from stickslip.rigs.contract import Command, Log, Rig, RigLimits

__all__ = ["Command", "Log", "Rig", "RigLimits"]
