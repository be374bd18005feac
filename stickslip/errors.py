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

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from stickslip.fmi.errors import Fault
from stickslip.fmi.messages import printable

_STYLE = "STICKSLIP_SETTINGS"
"""Variable of the environment of a command, and of the processes that it starts."""
_SETTING = re.compile(
    "<(column|compensator|confirm|controller|drive|encoder_step|evaluations|fixed|force"
    "|force_limit|friction_range|gain|input|law|motion|out|rated_force|rated_torque|resume|rig|sample_period"
    "|scale|seconds|seed|seeds|set|span|stop|tunings|unit)(?: ([^<>]+))?>"
)

_PAIR = re.compile(r"(\w+)=(.*?)(?= \w+=|$)")
_OTHERWISE = {
    "drive": "drives", "force": "force=True", "gain": "gains", "input": "inputs",
    "out": "folder", "resume": "resume=True", "set": "parameters",
}  # fmt: skip
"""What is called in Python otherwise than by the word of its option."""
_FIELDS = {
    "fixed": "gains stay as they are",
    "force": "write what is not recommended",
    "gain": "gains",
    "law": "Friction law",
    "compensator": "Compensator",
    "evaluations": "Candidates",
    "input": "Input signals",
    "set": "Inputs and parameters",
    "stop": "Stop time [s]",
}
"""What is called on the page of the workbench otherwise."""


@contextmanager
def settings_as_options() -> Iterator[None]:
    """Let messages name settings as options of the command line."""
    name_settings("options")
    try:
        yield
    finally:
        name_settings("keywords")


def name_settings(style: str) -> None:
    """Let messages of this process name settings as ``options``, ``keywords`` or ``fields``."""
    os.environ[_STYLE] = style


def settings_style() -> str:
    """Return how messages of this process name settings."""
    return os.environ.get(_STYLE, "keywords")


def with_settings(text: str) -> str:
    """Return a message in which settings are options in a command, and keywords in Python.

    ``<sample_period 0.01>`` is ``--sample-period 0.01`` or ``sample_period=0.01``, and
    ``<unit time=ms>`` is ``--unit time=ms`` or ``columns={"time": Column(unit="ms")}``. ``<out>``
    is a folder, of a command that of ``--out``, and ``<resume>`` is ``resume=True`` in Python. On
    the page of the workbench settings are fields.
    """
    styles = {"options": _option, "fields": _field}
    return _SETTING.sub(styles.get(settings_style(), _keyword), text)


def _option(found: re.Match[str]) -> str:
    if found[1] == "out":
        return "folder with --out"
    return f"--{found[1].replace('_', '-')} {found[2] or ''}".rstrip()


def _keyword(found: re.Match[str]) -> str:
    name, value = found.groups()
    if name in _OTHERWISE:
        return _OTHERWISE[name]
    if name in ("column", "unit", "scale") and value:
        pairs = _PAIR.findall(value)
        part = name.replace("column", "name")
        columns = (f'"{role}": Column({part}={_literal(text)})' for role, text in pairs)
        return f"columns={{{', '.join(columns)}}}"
    if name in ("confirm", "span") and value:
        return f"{name}=({', '.join(map(_literal, value.split()))},)"
    return f"{name}={_literal(value)}" if value else name


def _field(found: re.Match[str]) -> str:
    name, value = found.groups()
    if name in ("column", "unit", "scale") and value:
        of = "" if name == "column" else f"{name}' of '"
        pairs = _PAIR.findall(value)
        fields = (f"{text} in the field '{of}{role.replace('_', ' ')}'" for role, text in pairs)
        return ", ".join(fields)
    label = f"the field '{_FIELDS.get(name, name.replace('_', ' '))}'"
    return f"{value} in {label}" if value else label


def _literal(value: str) -> str:
    """Return a value in quotes, but for a number or a placeholder in capitals."""
    return value if re.fullmatch(r"[-+.\d]+(e[-+]?\d+)?|[A-Z]+", value) else f'"{value}"'


class StickslipError(Fault):
    """A command cannot go on; the message is for the user."""

    def __init__(self, message: str = "", *further: object) -> None:
        super().__init__(with_settings(message), *further)


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
