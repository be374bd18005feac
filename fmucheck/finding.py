"""Findings of a check, and the report of one file."""

from __future__ import annotations

import enum
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path


class Severity(enum.IntEnum):
    """How much a finding matters."""

    NOTE = 0
    """Worth knowing, or not checked."""
    WARNING = 1
    """Allowed, but some tools will stumble; or the standard only recommends otherwise."""
    ERROR = 2
    """Against the standard, or it does not work."""

    def __str__(self) -> str:
        return self.name.lower()


@dataclass(frozen=True)
class Finding:
    """One thing found.

    Attributes
    ----------
    rule : id of the rule, a row of ``docs/check.md``
    place : file, element or call it is about
    section : of the standard, such as ``FMI 3.0.2, 2.4.7``; empty when no section rules it
    advice : what to do about it
    """

    severity: Severity
    rule: str
    place: str
    message: str
    section: str
    advice: str

    def as_json(self) -> dict[str, str]:
        """Return plain data."""
        return {
            "severity": str(self.severity),
            "rule": self.rule,
            "place": self.place,
            "message": self.message,
            "section": self.section,
            "advice": self.advice,
        }


@dataclass
class Report:
    """All findings about one file, the gravest first once it is done.

    ``fmi`` is the version that the file claims, ``None`` while it cannot be read.
    """

    path: Path
    fmi: str | None = None
    findings: list[Finding] = field(default_factory=list)

    def __iter__(self) -> Iterator[Finding]:
        return iter(self.findings)

    def count(self, severity: Severity) -> int:
        """Return how many findings have this severity."""
        return sum(finding.severity is severity for finding in self.findings)

    @property
    def rules(self) -> set[str]:
        """The ids of all rules that found something."""
        return {finding.rule for finding in self.findings}

    def as_json(self) -> dict[str, object]:
        """Return plain data; the keys are part of the interface."""
        return {
            "file": str(self.path),
            "fmi": self.fmi,
            "errors": self.count(Severity.ERROR),
            "warnings": self.count(Severity.WARNING),
            "notes": self.count(Severity.NOTE),
            "findings": [finding.as_json() for finding in self.findings],
        }
