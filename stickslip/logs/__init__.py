"""Logs of drives: read, checked, put on an even grid."""

from stickslip.logs.channels import UNSTATED
from stickslip.logs.checked import read_and_check, read_stretches, with_checks
from stickslip.logs.checks import check_recording
from stickslip.logs.description import Column, Controller, Description, load_description
from stickslip.logs.motion import aligned, samples_late
from stickslip.logs.reading import Reading, raise_errors, read_recording
from stickslip.logs.recording import Finding, Motion, Recording

__all__ = [
    "UNSTATED",
    "Column", "Controller", "Description", "Finding", "Motion", "Reading", "Recording",
    "aligned", "check_recording", "load_description", "raise_errors", "read_and_check",
    "read_recording", "read_stretches", "samples_late", "with_checks",
]  # fmt: skip
