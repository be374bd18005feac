"""Findings of checks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Severity = Literal["error", "warning", "note"]


@dataclass(frozen=True)
class Finding:
    """One finding of a check of a recording; as text it is one line."""

    severity: Severity  # error (nothing can be learned), warning (something will suffer), note
    what: str  # was found
    figure: str = ""  # the number behind it, with its unit
    advice: str = ""  # what to do; empty when nothing need be done
    # "intervals" where the learned intervals are too narrow, "values" where the learned values are
    # wrong
    spoils: Literal["", "intervals", "values"] = ""
    hides: tuple[str, ...] = ()  # parameters that cannot be identified therefore

    @classmethod
    def either(cls, fine: bool, words: tuple[str, str], figure: str, advice: str) -> Finding:
        """Return a note without advice, or a warning."""
        note, warning = words
        return cls("note", note, figure) if fine else cls("warning", warning, figure, advice)

    def __str__(self) -> str:
        figure = f": {self.figure}" if self.figure else ""
        advice = f"; {self.advice}" if self.advice else ""
        return f"{self.severity}: {self.what}{figure}{advice}"
