"""How a text file writes its numbers: delimiter, decimal point or comma, header or none."""

from __future__ import annotations

import contextlib
import csv
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from stickslip.logs.units import unit_named

_DELIMITERS = ("\t", ";", ",", "|", " ")
_BRACKETED = re.compile(r"^(.*?)\s*[\[(]\s*([^\])]*?)\s*[\])]$")
_BEHIND = re.compile(r"^(.+?)(?:\s*,\s*|\s+/\s*|\s+in\s+)([^,\s]+)$")
_GROUPED = re.compile(r"[-+]?\d{1,3}(\.\d{3})+,\d*")
"""A number such as 1.234,5."""
_SAMPLE = 200
_SAMPLED = 1 << 18
"""Characters of lines that are looked at."""
_LONGEST_NAME = 200


@dataclass(frozen=True)
class Dialect:
    """How lines become fields and fields numbers.

    Attributes
    ----------
    delimiter : one character; a space stands for any white space
    decimal : . or ,
    """

    delimiter: str
    decimal: str

    def fields(self, line: str) -> list[str]:
        """Return the fields of a line, without quotes and white space around them."""
        if self.delimiter == " ":
            return line.split()
        if '"' in line:
            with contextlib.suppress(csv.Error):
                row = next(csv.reader([line], delimiter=self.delimiter))
                return [field.strip() for field in row]
        return [field.strip() for field in line.split(self.delimiter)]

    def number(self, field: str) -> float | None:
        """Return the number that a field holds, None when it is not a number."""
        if self.decimal == ",":
            if _GROUPED.fullmatch(field):
                field = field.replace(".", "")
            field = field.replace(",", ".")
        try:
            return float(field)
        except ValueError:
            return None


def find_dialect(lines: Sequence[str], delimiter: str | None, decimal: str | None) -> Dialect:
    """Return the dialect in which the last lines hold most numbers, equally many per line."""
    longest = max(len(line) for line in lines[-_SAMPLE - 1 :])
    some = min(_SAMPLE, max(3, _SAMPLED // max(1, longest)))
    sample = lines[-some - 1 : -1] or lines

    def score(dialect: Dialect) -> int:
        rows = [dialect.fields(line) for line in sample]
        width = commonest(map(len, rows))
        fields = [field for row in rows if len(row) == width for field in row]
        return sum(dialect.number(field) is not None for field in fields)

    marks = [delimiter] if delimiter else _DELIMITERS
    points = [decimal] if decimal else [".", ","]
    return max((Dialect(m, p) for m in marks for p in points if m != p), key=score)


def commonest(counts: Iterable[int]) -> int:
    """Return the most frequent count; 1 if there is none."""
    return max(Counter(counts).items(), key=lambda item: item[1], default=(1, 0))[0]


def split_unit(text: str) -> tuple[str, str | None]:
    """Return name and unit of a header such as ``Position [mm]``, ``t / s`` or ``Force, N``."""
    if len(text) > _LONGEST_NAME:
        return text, None
    if match := _BRACKETED.match(text):
        name, unit = match.groups()
        if name and unit and not unit.isdecimal():
            return name, unit
    if (match := _BEHIND.match(text)) and unit_named(match.group(2)):
        return match.group(1), match.group(2)
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
