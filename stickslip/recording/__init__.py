"""Logs of drives: read, checked, put on an even grid."""

from stickslip.recording.checks import check_recording
from stickslip.recording.configuration import load_description
from stickslip.recording.controller import Controller, Kind
from stickslip.recording.delay import Delay, aligned, force_delay, signal_delay
from stickslip.recording.description import ROLES, Column, Description
from stickslip.recording.excitation import Excitation, TurnAround, excitation
from stickslip.recording.finding import Finding, Severity
from stickslip.recording.reading import Reading, read_recording
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
    "excitation",
    "force_delay",
    "load_description",
    "read_recording",
    "signal_delay",
]
