"""How a text file writes its numbers: delimiter, decimal point or comma, header or none."""

from __future__ import annotations

import contextlib
import csv
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

from stickslip.errors import UsageError
from stickslip.logs.units import unit_named

_DELIMITERS = ("\t", ";", ",", "|", " ")
_BEHIND = re.compile(r"(?:,|\s/|\sin\s)\s*([^,\s]+)$")
_GROUPED = re.compile(r"[-+]?\d{1,3}(\.\d{3})+,\d*")  # a number such as 1.234,5
_WHITE = re.compile(r"\s")
_FIRST = frozenset("+-.,0123456789nNiI")  # how a number begins
MISSING = frozenset(
    ("", "-", "--", "---", "n/a", "na", "n.a.", "#n/a", "null", "none", "nil", "?", "1.#qnan")
)
"""What stands where a value is missing, in small letters."""
SAMPLE = 200  # lines that are looked at, from all over a text and at its end
SAMPLED = 1 << 18  # characters of lines that are looked at
_LONGEST_NAME = 200


@dataclass(frozen=True)
class Dialect:
    """How lines become fields and fields numbers."""

    delimiter: str  # one character; a space stands for any white space
    decimal: str  # . or ,
    width: int = 0  # fields of a line of data; 0 where no line holds a number

    def fields(self, line: str) -> list[str]:
        """Return the fields of a line, without quotes and white space around them."""
        if self.delimiter == " ":
            return line.split()
        if '"' in line:
            with contextlib.suppress(csv.Error):
                row = next(csv.reader([line], delimiter=self.delimiter))
                return [field.strip() for field in row]
        fields = line.split(self.delimiter)
        return [field.strip() for field in fields] if _WHITE.search(line) else fields

    def number(self, field: str) -> float | None:
        """Return the number that a field holds, None when it is not a number."""
        if field[:1] not in _FIRST:
            return None
        if self.decimal == ",":
            if _GROUPED.fullmatch(field):
                field = field.replace(".", "")
            field = field.replace(",", ".")
        try:
            return float(field)
        except ValueError:
            return None


def find_dialect(
    path: str, lines: Sequence[str], delimiter: str | None, decimal: str | None
) -> Dialect:
    """Return the dialect in which some lines hold most numbers, equally many fields per line.

    Raises UsageError when delimiter and decimal sign are the same, and no quotes tell them apart.
    """
    most = max(3, SAMPLED // max(map(len, lines)))
    sample = lines[:: max(1, len(lines) // most)]
    quoted = any('"' in line for line in sample)
    if delimiter and delimiter == decimal and not quoted:
        raise UsageError(
            f"{path}: delimiter and decimal sign are both '{delimiter}': expected numbers in "
            f"quotes, got '{lines[-1][:40]}'; export the log with another delimiter"
        )

    def numbers(dialect: Dialect) -> Counter[int]:
        count: Counter[int] = Counter()
        for line in sample:
            row = dialect.fields(line)
            count[len(row)] += sum(dialect.number(field) is not None for field in row)
        return count

    marks = [delimiter] if delimiter else _DELIMITERS
    points = [decimal] if decimal else [".", ","]
    found = [Dialect(m, p) for m in marks for p in points if m != p or quoted]
    counts = {dialect: numbers(dialect).most_common(1)[0] for dialect in found}
    best = max(found, key=lambda dialect: counts[dialect][1])
    width, count = counts[best]
    return replace(best, width=width if count else 0)


def split_unit(text: str) -> tuple[str, str | None]:
    """Return name and unit of a header such as ``Position [mm]``, ``t / s`` or ``Force, N``."""
    if len(text) > _LONGEST_NAME:
        return text, None
    if text.endswith(("]", ")")):
        closed = max(text.rfind("]", 0, -1), text.rfind(")", 0, -1))
        name, bracket, unit = re.sub(r"[\[(]", "[", text[closed + 1 : -1]).partition("[")
        name = (text[: closed + 1] + name).strip()
        if name and bracket and (unit := unit.strip()) and not unit.isdecimal():
            return name, unit
    if (match := _BEHIND.search(text)) and unit_named(match[1]) and text[: match.start()].strip():
        return text[: match.start()].strip(), match[1]
    return text, None


def states_units(fields: Sequence[str]) -> bool:
    """Whether a row holds units: mostly known ones, or all in brackets."""
    filled = [field for field in fields if field not in ("", "-")]
    known = sum(unit_named(unbracketed(field)) is not None for field in filled)
    bracketed = all(re.fullmatch(r"\[.*\]|\(.*\)", field) for field in filled)
    return bool(filled) and (2 * known > len(filled) or bracketed)


def unbracketed(field: str) -> str:
    """Return a unit without the brackets around it."""
    return field.strip("[](){} ")
