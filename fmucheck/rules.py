"""The table of rules. A rule is one function that yields where and what it finds.

Its id is the function's name, its summary the docstring; the stage, which says what it is given, is
the package it lies in. So a rule exists in one place, and ``docs/check.md`` can list them all.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from stickslip.fmucheck.finding import Finding, Severity

Claim = tuple[str, str]
"""Place and message."""
Claims = Iterable[Claim]

_STANDARDS = {2: "FMI 2.0.5", 3: "FMI 3.0.2"}
_STAGES = [
    "archive",
    "document",
    "description",
    "files",
    "binaries",
    "running",
    "rerunning",
    "ending",
]
_MOST = 20  # findings of one rule about one file that are reported


@dataclass(frozen=True)
class Rule:
    """One rule.

    Attributes
    ----------
    stage : what ``check`` is given: archive, document, description, files, binaries or running
    sections : of each version it applies to, the section that rules it, or "" for none
    """

    id: str
    severity: Severity
    stage: str
    sections: dict[int, str]
    summary: str
    advice: str
    check: Callable[[Any], Claims]

    def finding(self, claim: Claim, version: int | None) -> Finding:
        """Return what was claimed with all that this rule knows."""
        section = self.sections.get(version or 0, "")
        return Finding(
            severity=self.severity,
            rule=self.id,
            place=claim[0],
            message=claim[1],
            section=f"{_STANDARDS[version or 0]}, {section}" if section else "",
            advice=self.advice,
        )

    def findings(self, subject: object, version: int | None) -> Iterator[Finding]:
        """Yield what this rule finds, if it applies to this version."""
        if version and version not in self.sections:
            return
        for number, claim in enumerate(self.check(subject)):
            if number == _MOST:
                yield self.finding(("", f"and more; the first {_MOST} are listed"), version)
                return
            yield self.finding(claim, version)


RULES: dict[str, Rule] = {}


def rule(
    severity: Severity, *, fmi2: str | None, fmi3: str | None, advice: str
) -> Callable[[Callable[[Any], Claims]], Callable[[Any], Claims]]:
    """Register a function as a rule.

    Parameters
    ----------
    fmi2, fmi3 : the section of the standard; "" when none rules it, None when it does not apply
    advice : what to do, in a few words
    """

    def register(check: Callable[[Any], Claims]) -> Callable[[Any], Claims]:
        name = check.__name__.replace("_", "-")
        sections = {2: fmi2, 3: fmi3}
        RULES[name] = Rule(
            id=name,
            severity=severity,
            stage=check.__module__.split(".")[2],
            sections={v: s for v, s in sections.items() if s is not None},
            summary=(check.__doc__ or "").split("\n")[0],
            advice=advice,
            check=check,
        )
        return check

    return register


def stage(name: str) -> list[Rule]:
    """Return the rules of one stage, in the order they were written down."""
    return [each for each in RULES.values() if each.stage == name]


def table() -> str:
    """Return all rules as a table in Markdown."""
    rows = ["| rule | severity | FMI 2.0.5 | FMI 3.0.2 | finds |", "|---|---|---|---|---|"]
    for each in sorted(RULES.values(), key=lambda each: _STAGES.index(each.stage)):
        sections = " | ".join(each.sections.get(v, "–") for v in (2, 3))
        rows.append(f"| `{each.id}` | {each.severity} | {sections} | {each.summary} |")
    return "\n".join(rows)
