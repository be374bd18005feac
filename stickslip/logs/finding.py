"""Findings of checks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from stickslip.errors import with_settings

Severity = Literal["error", "warning", "note"]


@dataclass(frozen=True)
class Finding:
    """One finding of a check of a recording; as text it is one line.

    Attributes
    ----------
    severity : error (nothing can be learned), warning (something will suffer), note
    what : was found
    figure : the number behind it, with its unit
    advice : what to do; empty when nothing need be done; settings as in ``errors.with_settings``
    spoils : "intervals" where the learned intervals are too narrow, "values" where the learned
        values are wrong
    hides : parameters that cannot be identified therefore
    """

    severity: Severity
    what: str
    figure: str = ""
    advice: str = ""
    spoils: Literal["", "intervals", "values"] = ""
    hides: tuple[str, ...] = ()

    @classmethod
    def either(cls, fine: bool, words: tuple[str, str], figure: str, advice: str) -> Finding:
        """Return a note without advice, or a warning."""
        note, warning = words
        return cls("note", note, figure) if fine else cls("warning", warning, figure, advice)

    def __post_init__(self) -> None:
        for name in ("what", "advice"):
            object.__setattr__(self, name, with_settings(getattr(self, name)))

    def __str__(self) -> str:
        figure = f": {self.figure}" if self.figure else ""
        advice = f"; {self.advice}" if self.advice else ""
        return f"{self.severity}: {self.what}{figure}{advice}"
