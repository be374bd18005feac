"""Logs of drives: read, checked, put on an even grid."""

from stickslip.logs.checked import read_and_check, shortened
from stickslip.logs.checks import check_recording
from stickslip.logs.description import (
    ROLES,
    Column,
    Controller,
    Description,
    Kind,
    load_description,
)
from stickslip.logs.excitation import Excitation, TurnAround, excitation
from stickslip.logs.motion import aligned, force_delay, samples_late, signal_delay
from stickslip.logs.plausibility import check_units, implausible_mass
from stickslip.logs.reading import Reading, raise_errors, read_recording
from stickslip.logs.recording import Finding, Motion, Recording

__all__ = [
    "ROLES",
    "Column",
    "Controller",
    "Description",
    "Excitation",
    "Finding",
    "Kind",
    "Motion",
    "Reading",
    "Recording",
    "TurnAround",
    "aligned",
    "check_recording",
    "check_units",
    "excitation",
    "force_delay",
    "implausible_mass",
    "load_description",
    "raise_errors",
    "read_and_check",
    "read_recording",
    "samples_late",
    "shortened",
    "signal_delay",
]
