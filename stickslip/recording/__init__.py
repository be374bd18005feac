"""Logs of drives: read, checked, put on an even grid."""

from stickslip.recording.recording import Motion, Recording

__all__ = ["Motion", "Recording"]
