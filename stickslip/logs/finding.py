"""What a check of a recording found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Severity = Literal["error", "warning", "note"]


@dataclass(frozen=True)
class Finding:
    """One remark on a recording; as text it is one line.

    Attributes
    ----------
    severity : error (nothing can be learned), warning (something will suffer), note
    what : was found
    figure : the number behind it, with its unit
    advice : what to do; empty when nothing need be done
    spoils : "intervals" where values learned from the recording may be off by more than these tell,
        "values" where they are wrong
    """

    severity: Severity
    what: str
    figure: str = ""
    advice: str = ""
    spoils: Literal["", "intervals", "values"] = ""

    def __str__(self) -> str:
        figure = f": {self.figure}" if self.figure else ""
        advice = f"; {self.advice}" if self.advice else ""
        return f"{self.severity}: {self.what}{figure}{advice}"
