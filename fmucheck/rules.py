"""Rules, their findings, and the report of one file."""

import enum
import itertools
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar


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
    """One thing found, at one or more places.

    Attributes
    ----------
    rule : id of the rule, a row of ``docs/check.md``
    place : file, element or call it is about
    section : of the standard, such as ``FMI 3.0.2, 2.4.7``; empty when no section rules it
    advice : what to do about it
    count : of the places with the same cause
    others : the further places, up to a limit
    """

    severity: Severity
    rule: str
    place: str
    message: str
    section: str
    advice: str
    count: int = 1
    others: tuple[str, ...] = ()

    def as_json(self) -> dict[str, object]:
        """Return plain data."""
        return asdict(self) | {"severity": str(self.severity), "others": list(self.others)}

    @property
    def cause(self) -> tuple[str, str]:
        """The rule, and the message without what differs from place to place."""
        text = self.message
        for word in re.findall(r"[\w.\[\]]{2,}", self.place):
            text = text.replace(word, "")
        return self.rule, _VARYING.sub("", text)


_VARYING = re.compile(r"'[^']*'|\(line \d+\)|[-+]?\d[\w.+-]*|\b(?:True|False|inf|nan)\b")
_LISTED = 20  # further places of one finding, and causes of one rule


def grouped(findings: Iterable[Finding]) -> list[Finding]:
    """Return one finding per cause, the gravest first; of many causes the last stands for more."""
    causes: dict[tuple[str, str], list[Finding]] = {}
    of_rule: dict[str, int] = {}
    for found in dict.fromkeys(findings):  # both interfaces may say the same
        cause = found.cause
        if cause not in causes:
            of_rule[found.rule] = of_rule.get(found.rule, 0) + 1
            if of_rule[found.rule] > _LISTED:
                cause = found.rule, ""
        causes.setdefault(cause, []).append(found)
    merged = []
    for first, *more in causes.values():
        others = tuple(f.place for f in more[:_LISTED])
        merged.append(replace(first, count=1 + len(more), others=others))
    return sorted(merged, key=lambda found: -found.severity)


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


Claim = tuple[str, str]
"""Place and message."""
Claims = Iterable[Claim]
_STANDARDS = {2: "FMI 2.0.5", 3: "FMI 3.0.2"}
STAGES = ["archive", "document", "description", "files", "binaries"]
STAGES += ["running", "rerunning", "ending"]
_MOST = 10_000  # claims of one rule about one file that are counted


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
        section = f"{_STANDARDS[version or 0]}, {section}" if section else ""
        return Finding(self.severity, self.id, *claim, section, self.advice)

    def findings(self, subject: object, version: int | None) -> Iterator[Finding]:
        """Yield what this rule finds, if it applies to this version."""
        if version and version not in self.sections:
            return
        for claim in itertools.islice(self.check(subject), _MOST):
            yield self.finding(claim, version)


RULES: dict[str, Rule] = {}
Check = TypeVar("Check", bound=Callable[[Any], Iterable[Any]])


def _rule(severity: Severity) -> Callable[..., Callable[[Check], Check]]:
    """Return a decorator that registers a function as a rule of this severity.

    Its arguments are the sections of FMI 2.0.5 and 3.0.2 ("" when none applies, None when the rule
    does not apply to this version), and what to do, in a few words. The function is given what its
    stage checks, by default that of its module, and yields claims; where ``each`` names an
    attribute of that, it is given one of the things in it and yields messages, whose place is that
    of the thing, of a member of an archive its name.
    """

    def decorator(
        fmi2: str | None, fmi3: str | None, advice: str, each: str = "", *, stage: str = ""
    ) -> Callable[[Check], Check]:
        def register(check: Check) -> Check:
            def claims(subject: Any) -> Claims:
                for thing in getattr(subject, each):
                    place = getattr(thing, "place", None) or thing.orig_filename
                    for message in check(thing):
                        yield place, message

            sections = {2: fmi2, 3: fmi3}
            rule = Rule(
                id=check.__name__.replace("_", "-"),
                severity=severity,
                stage=stage or check.__module__.split(".")[2],
                sections={v: s for v, s in sections.items() if s is not None},
                summary=(check.__doc__ or "").split("\n")[0],
                advice=advice,
                check=claims if each else check,
            )
            RULES[rule.id] = rule
            return check

        return register

    return decorator


error, warning, note = _rule(Severity.ERROR), _rule(Severity.WARNING), _rule(Severity.NOTE)


def stage(name: str) -> list[Rule]:
    """Return the rules of one stage, in the order they were written down."""
    return [each for each in RULES.values() if each.stage == name]


def table() -> str:
    """Return all rules as a table in Markdown."""
    rows = ["| rule | severity | FMI 2.0.5 | FMI 3.0.2 | finds |", "|---|---|---|---|---|"]
    for each in sorted(RULES.values(), key=lambda each: STAGES.index(each.stage)):
        sections = " | ".join(each.sections.get(v, "–") for v in (2, 3))
        rows.append(f"| `{each.id}` | {each.severity} | {sections} | {each.summary} |")
    return "\n".join(rows)
