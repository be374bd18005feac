"""Errors of the application, and a check that raises one.

StickslipError(Fault)
    UsageError(ValueError)              an option, name or value that a command cannot take
    RecordingError(ValueError)          a log's file that cannot become a recording
    IdentificationError(RuntimeError)   a recording does not show what is looked for
    HarmfulError(RuntimeError)          a compensator that makes its loop worse, or was not tried
    ResultsError(RuntimeError)          a folder of results that is not what its manifest says
    RigError(RuntimeError)              a rig cannot run a command, or did not run it to its end
        LimitError                      a limit refused a command, or aborted its motion
"""

from typing import Any

from stickslip.fmi.errors import Fault
from stickslip.fmi.messages import printable


class StickslipError(Fault):
    """A command cannot go on; the message is for the user."""


class UsageError(StickslipError, ValueError):
    """An option, name or value that a command cannot take."""


class RecordingError(StickslipError, ValueError):
    """A log's file that cannot become a recording."""


class IdentificationError(StickslipError, RuntimeError):
    """A recording does not show what an experiment looks for."""


class HarmfulError(StickslipError, RuntimeError):
    """A compensator makes the loop worse that it is for, or was not tried in one."""


class ResultsError(StickslipError, RuntimeError):
    """A folder of results has no manifest, or is not what its manifest says."""


class RigError(StickslipError, RuntimeError):
    """A rig cannot run a command, or did not run it to its end."""


class LimitError(RigError):
    """A limit refused a command, or aborted its motion."""


def number(what: str, value: Any) -> float:
    """Return a value as a number; raise UsageError when it is none."""
    try:
        return float(value)
    except (TypeError, ValueError):
        raise UsageError(f"{what}: expected a number, got {printable(repr(value), 80)}") from None
