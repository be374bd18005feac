"""How a text file writes its numbers, what its columns are called, and how they belong together."""

import contextlib
import csv
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain, islice, pairwise

from stickslip.errors import UsageError
from stickslip.logs.roles import is_time, role_named
from stickslip.logs.table import is_clock
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


_KEPT = 8  # lines of text that are looked at for names, at both ends of those right above the data
_SCORED = 200  # fields of such a line of which it is counted how many name signals
_LONGEST_KEY = 40
LOOKED_AT = 100_000  # most lines above the first that holds a number or a time; they take 1 s
_NAMES = ("name", "signalname", "symbolname", "signal", "bezeichnung")
_UNITS = ("unit", "units", "einheit")
_PERIOD = ("sampletimems", "sampletime")
_KEYS = {
    *(*_NAMES, *_UNITS, *_PERIOD, "file", "title", "symbolcomment", "comment", "kommentar"),
    *("datatype", "datentyp", "variablesize", "symbolbased", "indexgroup", "indexoffset", "netid"),
    *("port", "offset", "scalefactor", "bitmask", "unitscalefactor", "unitoffset", "amsnetid"),
    *("starttimeofexport", "endtimeofexport", "starttimeofrecord", "endtimeofrecord"),
    *("description", "beschreibung", "symbolpath", "arraylength", "acquisition"),
}
"""What begins a row of a header in which each row has a title, such as those of TwinCAT Scope."""

Line = tuple[int, str]  # number and text of a line


@dataclass(frozen=True)
class Header:
    """What stands above the data."""

    begin: int  # number of the first line of data
    width: int  # fields of a line of data
    names: list[str]  # of the columns; empty when the file names none
    units: list[str | None]
    paired: bool = False  # whether columns take turns: times, and a signal at these times
    titled: bool = False  # whether each row of the header has a title; times may then lack a unit
    periods: tuple[tuple[int, float], ...] = ()  # sample periods [ms] by column, where it has them


def is_data(text: str) -> bool:
    """Whether a line is not a comment."""
    return not text.startswith(("#", "%"))


def find_header(lines: Iterable[Line], dialect: Dialect) -> Header:
    """Return the header above the first line that holds mostly numbers.

    Names are those of the last line of the right length without a number, or of one above it that
    names more of the signals that are looked for; text above is left out.
    """
    width = dialect.width
    above: list[list[str]] = []
    titled: dict[str, list[str]] = {}
    begin = below = last = k = filled = 0
    looked_at = islice(lines, LOOKED_AT)
    for k, ((number, text), (_, following)) in enumerate(pairwise(chain(looked_at, [(0, "")]))):
        row = dialect.fields(text.lstrip("#% "))
        key = re.sub(r"[\W\d_]", "", row[0][:_LONGEST_KEY]).lower() if row else ""
        if key in _KEYS:
            titled[key] = row
        elif titled or len(row) == width:
            known = _known(row, dialect)
            if 0 < len(row) <= 2 * known:
                after = dialect.fields(following) if following else row
                if len(after) != len(row) or len(after) <= 2 * _known(after, dialect):
                    begin = number
                    break
            if known or any(map(is_clock, row)):
                filled += 1
            elif len(row) == width:
                joined = bool(above) and k == last + 1
                if named := any(field.lower() not in MISSING for field in row):
                    above = [*above, row] if joined else [row]
                    del above[_KEPT:-_KEPT]
                if named or joined:
                    last, below = k, number + 1
    if k + 1 == LOOKED_AT and not (begin or filled):
        return Header(0, 0, [], [])
    if names := next((titled[key] for key in _NAMES if len(titled) > 1 and key in titled), None):
        return _titled(begin, width, names, titled, dialect=dialect)
    if not above:
        return Header(begin, width, [], [])
    names, units = _above(above)
    paired = width >= 4 and all(map(is_time, names[::2])) and not any(map(is_time, names[1::2]))
    return Header(below, width, names, units, paired=paired)


def _known(row: list[str], dialect: Dialect) -> int:
    """Return how many fields are numbers."""
    return sum(dialect.number(field) is not None for field in row)


def _above(above: list[list[str]]) -> tuple[list[str], list[str | None]]:
    """Return names and units from the lines right above the data."""
    places = [k for k, row in enumerate(above) if not states_units(row)] or [len(above) - 1]

    def signals(row: list[str]) -> int:
        return sum(role_named(split_unit(field)[0]) is not None for field in row[:_SCORED])

    best = max(places, key=lambda k: (signals(above[k]), k))
    split = [split_unit(field) for field in above[best]]
    stated = next((row for row in above[best + 1 :] if states_units(row)), None)
    if stated is None and states_units(above[best]):
        stated = above[best]
    units = [unbracketed(field) or None for field in stated] if stated else [u for _, u in split]
    return [name for name, _ in split], units


def _titled(
    begin: int, width: int, row: list[str], titled: dict[str, list[str]], dialect: Dialect
) -> Header:
    """Return what a header of titled rows states: TITLE, A, B or TITLE, A, TITLE, B."""
    while len(row) > 2 and not row[-1]:
        row = row[:-1]
    paired = len(row) == 2 == width or (len(row) > 3 and row[0] == row[2])
    unit_row = next((titled[key] for key in _UNITS if key in titled), [])
    period_row = next((titled[key] for key in _PERIOD if key in titled), [])
    places = range(1, len(row), 2 if paired else 1)
    names, units = ["time"] * (places[-1] + 1), [None] * (places[-1] + 1)
    found: list[str | None] = [*units]
    periods = []
    for k in places:
        names[k], found[k] = split_unit(row[k])
        if k < len(unit_row) and (unit := unbracketed(unit_row[k])):
            found[k] = None if unit.lower() == "none" else unit
        period = dialect.number(period_row[k]) if k < len(period_row) else None
        if period is not None and period > 0:
            periods.append((k, period))
    return Header(
        begin, len(names), names, found, paired=paired, titled=True, periods=tuple(periods)
    )
