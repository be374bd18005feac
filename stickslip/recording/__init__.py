"""Logs of drives: read, checked, put on an even grid."""

from stickslip.recording.configuration import load_description
from stickslip.recording.controller import Controller, Kind
from stickslip.recording.description import ROLES, Column, Description
from stickslip.recording.finding import Finding, Severity
from stickslip.recording.reading import Reading, read_recording
from stickslip.recording.recording import Motion, Recording

__all__ = [
    "ROLES",
    "Column",
    "Controller",
    "Description",
    "Finding",
    "Kind",
    "Motion",
    "Reading",
    "Recording",
    "Severity",
    "load_description",
    "read_recording",
]
