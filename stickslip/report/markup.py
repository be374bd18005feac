"""HTML from small parts: what is not markup yet is escaped."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from html import escape

from stickslip.catalog.parameters import UNITS
from stickslip.identification.stages import Estimate
from stickslip.report.quantity import SCALES, SYMBOLS, number, unit, with_error


class Html(str):
    """Text that is markup already."""

    __slots__ = ()


def text(content: str) -> Html:
    """Return a text as markup, escaped unless it is markup already."""
    return content if isinstance(content, Html) else Html(escape(content))


def element(name: str, *content: str, **attributes: str) -> Html:
    """Return an element; attributes class_, aria_label are written class, aria-label."""
    written = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{escape(value)}"'
        for key, value in attributes.items()
    )
    return Html(f"<{name}{written}>{join(content)}</{name}>")


def join(parts: Iterable[str], between: str = "") -> Html:
    """Return parts one after another, with markup in between."""
    return Html(between.join(text(part) for part in parts))


def paragraph(*content: str) -> Html:
    """Return a paragraph."""
    return element("p", *content)


def symbol(letter: str, index: str = "") -> Html:
    """Return a symbol, its letter in italics and its index below the line."""
    below = element("sub", index) if index else ""
    return join([element("i", letter), below])


def table(
    head: Sequence[str], rows: Iterable[Sequence[str]], caption: str, words: Collection[int] = (0,)
) -> Html:
    """Return a table that scrolls by itself where the page is narrow.

    Parameters
    ----------
    head : titles of the columns
    rows : cells, the first of which names the row
    words : columns of words, set to the left; the others are numbers
    """

    def aligned(i: int) -> dict[str, str]:
        return {"class_": "word"} if i in words else {"class_": "number"}

    titles = join(element("th", cell, scope="col", **aligned(i)) for i, cell in enumerate(head))
    body = []
    for row in rows:
        first = element("th", row[0], scope="row")
        rest = join(element("td", cell, **aligned(i)) for i, cell in enumerate(row[1:], 1))
        body.append(element("tr", first, rest))
    whole = element(
        "table",
        element("caption", element("span", caption)),
        element("thead", element("tr", titles)),
        element("tbody", join(body, "\n")),
    )
    return element("div", whole, class_="scroll", tabindex="0", role="region", aria_label=caption)


METRICS = {"E_max": symbol("E", "max"), "E_rms": symbol("E", "rms")}


def parameter(name: str) -> Html:
    """Return the symbol of a parameter of Table 2."""
    return symbol(*SYMBOLS[name])


def parameter_unit(name: str) -> str:
    """Return the unit in which the page shows a parameter of Table 2."""
    return SCALES[name][1] if name in SCALES else unit(UNITS[name])


def parameter_value(name: str, value: float, digits: int = 5) -> str:
    """Return a value, given in SI, in that unit."""
    return number(value * _scale(name), digits)


def parameter_estimate(name: str, estimate: Estimate) -> str:
    """Return an estimate, given in SI, in that unit, with its standard error."""
    scale = _scale(name)
    return with_error(estimate.value * scale, estimate.standard_error * scale)


def _scale(name: str) -> float:
    return SCALES[name][0] if name in SCALES else 1.0
