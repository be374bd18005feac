"""Formats of logs, besides text: a module each, found by its place in this folder.

A module has ``recognises(data: bytes, suffix: str) -> bool``, which tells from a file's content or
from how its name ends (``.mat``) whether it is of this format, and
``read(path: str, data: bytes) -> LogTable``, which raises RecordingError.
"""
