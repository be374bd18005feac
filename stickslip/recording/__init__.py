"""Logs of drives: read, checked, put on an even grid."""

from stickslip.recording.checks import check_recording
from stickslip.recording.configuration import load_description
from stickslip.recording.controller import Controller, Kind
from stickslip.recording.delay import Delay, aligned, force_delay, samples_late, signal_delay
from stickslip.recording.description import ROLES, Column, Description
from stickslip.recording.excitation import Excitation, TurnAround, excitation
from stickslip.recording.finding import Finding, Severity
from stickslip.recording.plausibility import check_units, implausible_mass
from stickslip.recording.reading import Reading, raise_errors, read_recording
from stickslip.recording.recording import Motion, Recording

__all__ = [
    "ROLES",
    "Column",
    "Controller",
    "Delay",
    "Description",
    "Excitation",
    "Finding",
    "Kind",
    "Motion",
    "Reading",
    "Recording",
    "Severity",
    "TurnAround",
    "aligned",
    "check_recording",
    "check_units",
    "excitation",
    "force_delay",
    "implausible_mass",
    "load_description",
    "raise_errors",
    "read_recording",
    "samples_late",
    "signal_delay",
]
