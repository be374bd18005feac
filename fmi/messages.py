"""Texts in messages: names that are not trusted, what they may mean, and quantities."""

import difflib
import math
import re
from collections.abc import Iterable
from itertools import islice
from pathlib import Path
from unicodedata import category

_MOST = 5000  # names that are compared with one that is not known
_SCALABLE = re.compile(r"(m|s|N|N\.m|Nm|rad|A|V|W|J|K|Pa|Hz)(?![\w^*])")
_LETTERS = {"Real": "r", "Boolean": "b", "String": "s"}
_REFERENCE = re.compile(r"##|#([ribs])([0-9]{1,10})#")
_PREFIXES = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M"}


def shown(name: str, most: int = 80) -> str:
    """Return a name for a message: quoted, without control characters, cut short."""
    return repr(name if len(name) <= most else f"{name[:most]}...")


def printable(text: str, most: int = 200) -> str:
    """Return a text for a message: in one line, with control characters escaped."""
    line = "".join(c if c.isprintable() else repr(c)[1:-1] for c in text[:most])
    return line if len(text) <= most else f"{line}..."


def harmless(text: str) -> str:
    """Return untrusted text, in which what could move the cursor or turn the text is escaped."""
    if text.isprintable():
        return text
    return "".join(
        c if c.isprintable() or c == "\n" or category(c) == "Zs" else repr(c)[1:-1] for c in text
    )


def escaped(text: str) -> str:
    """Return untrusted text as HTML shows it."""
    from html import escape  # late, for those who start quickly

    return escape(harmless(text))


def named(text: str, variables: Iterable[tuple[str, int | None, str]]) -> str:
    """Return a message with names for references such as ``#r12#``. Source: FMI 2.0.5, 2.1.5."""
    if "#" not in text:
        return text
    names = {(_LETTERS.get(kind, "i"), number): name for kind, number, name in variables}

    def name(found: re.Match[str]) -> str:
        return names.get((found[1], int(found[2])), found[0]) if found[1] else "#"

    return _REFERENCE.sub(name, text)


def suggestion(name: str, names: Iterable[str]) -> str:
    """Return the end of an error message: what ``name`` may have meant, or what there is."""
    known = [printable(each, 80) for each in islice(names, _MOST)]
    name = name[:80]
    near = [each for each in known if each.lower() == name.lower()]
    if near := near or difflib.get_close_matches(name, known, n=3, cutoff=0.5):
        return f"; did you mean {' or '.join(map(repr, near))}?"
    shown = ", ".join(known[:12]) + (", ..." if len(known) > 12 else "")
    return f"; there is {shown}" if known else "; there is none"


def installing(extra: str) -> str:
    """Return the command that installs an extra: of this checkout, or of the installed package."""
    root = Path(__file__).resolve().parents[1]
    if not (root / "pyproject.toml").is_file():
        return f"pip install 'stickslip[{extra}]'"
    return f"pip install '{'.' if root == Path.cwd() else root}[{extra}]'"


def scaled_unit(unit: str | None, largest: float) -> tuple[float, str]:
    """Return factor and unit that show values of a size by numbers between 1 and 1000.

    Only a unit that begins with one that takes SI prefixes is scaled, such as m/s but not m2.
    """
    if not unit or not _SCALABLE.match(unit) or not 0.0 < largest < math.inf:
        return 1.0, unit or "1"
    # A largest value that is 1 but for rounding is 1, not 1000 thousandths.
    thousands = 3 * math.floor(math.log10(largest * (1.0 + 1e-9)) / 3)
    power = min(max(thousands, min(_PREFIXES)), max(_PREFIXES))
    return 10.0**-power, _PREFIXES[power] + unit


def quantity(value: float, unit: str, digits: int = 3) -> str:
    """Return a value with its unit and an SI prefix, such as ``0.4 µm``."""
    factor, scaled = scaled_unit(unit, abs(value))
    return f"{factor * value:.{digits}g} {scaled}"
