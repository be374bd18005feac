"""The header of a text file: what its columns are called, and how they belong together."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from stickslip.logs.dialect import Dialect, commonest, split_unit, states_units, unbracketed
from stickslip.logs.roles import role_named

_SAMPLE = 200
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

Line = tuple[int, str]
"""Number and text of a line."""


@dataclass(frozen=True)
class Header:
    """What stands above the data.

    Attributes
    ----------
    begin : index of the first line of data
    width : fields of a line of data
    names, units : of the columns; empty when the file names none
    paired : whether columns take turns: times, and a signal at these times
    titled : whether each row of the header has a title; times may then lack a unit
    periods : sample periods [ms] of the columns by number, where such a header states them
    """

    begin: int
    width: int
    names: list[str]
    units: list[str | None]
    paired: bool = False
    titled: bool = False
    periods: tuple[tuple[int, float], ...] = ()


def is_data(text: str) -> bool:
    """Whether a line is not a comment."""
    return not text.startswith(("#", "%"))


def find_header(lines: Sequence[Line], dialect: Dialect) -> Header:
    """Return the header above the first line that holds mostly numbers.

    Names are those of the last line of the right length without a number, or of one right above it
    that names more of the signals that are looked for; text above is left out.
    """
    width = commonest(len(dialect.fields(text)) for _, text in lines[-_SAMPLE:] if is_data(text))
    head: list[list[str]] = []
    above: list[int] = []
    titled: dict[str, list[str]] = {}
    begin = 0
    for k, (_, text) in enumerate(lines):
        row = dialect.fields(text.lstrip("#% "))
        key = re.sub(r"[\W\d_]", "", row[0]).lower() if row else ""
        if key in _KEYS:
            titled[key] = row
        elif (titled or len(row) == width) and _holds_numbers(row, dialect):
            following = dialect.fields(lines[k + 1][1]) if k + 1 < len(lines) else row
            if len(following) != len(row) or _holds_numbers(following, dialect):
                begin = k
                break
        elif len(row) == width and not any(dialect.number(field) is not None for field in row):
            above.append(k)
        head.append(row)
    if names := next((titled[key] for key in _NAMES if len(titled) > 1 and key in titled), None):
        return _titled(begin, width, names, titled, dialect)
    if not above:
        return Header(begin, width, [], [])
    names, units = _above(head, above)
    times = [(role_named(name) or ("",))[0] == "time" for name in names]
    paired = width >= 4 and all(times[::2]) and not any(times[1::2])
    return Header(above[-1] + 1, width, names, units, paired)


def _holds_numbers(row: list[str], dialect: Dialect) -> bool:
    known = sum(dialect.number(field) is not None for field in row)
    return known > 0 and 2 * known >= len(row)


def _above(head: list[list[str]], above: list[int]) -> tuple[list[str], list[str | None]]:
    """Return names and units from the lines right above the data."""
    last = above[-1]
    together = [k for k in above if all(j in above for j in range(k, last))]
    units: list[str | None] = []
    if len(together) > 1 and states_units(head[last]):
        units = [unbracketed(field) or None for field in head[last]]
        together.pop()
    split = {k: [split_unit(field) for field in head[k]] for k in together}
    best = max(together, key=lambda k: (sum(bool(role_named(name)) for name, _ in split[k]), k))
    names = [name for name, _ in split[best]]
    return names, units or [unit for _, unit in split[best]]


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
    return Header(begin, len(names), names, found, paired, titled=True, periods=tuple(periods))
