r"""HTML from small parts: text that is not markup yet is escaped, and symbols in it are set.

A symbol is written as in matplotlib: ``$F_c$``, ``$\sigma_0$``, ``$E_{rms}$``.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Sequence
from html import escape, unescape

from stickslip.fmi.messages import escaped

_SYMBOL = re.compile(r"\$(?:\\(?P<greek>[a-z]+)|(?P<latin>[A-Za-z]))(?:_\{?(?P<index>\w+)\}?)?\$")


class Html(str):
    """Text that is markup already."""

    __slots__ = ()


def text(content: str) -> Html:
    """Return a text as markup: escaped and with its symbols, unless it is markup already."""
    return content if isinstance(content, Html) else Html(_SYMBOL.sub(_set, escaped(content)))


def _set(found: re.Match[str]) -> str:
    """Return a symbol, its letter in italics and its index below the line."""
    greek, index = found["greek"], found["index"]
    letter = escape(unescape(f"&{greek};")) if greek else found["latin"]
    return f"<i>{letter}</i>" + (f"<sub>{index}</sub>" if index else "")


def element(name: str, *content: str, **attributes: str) -> Html:
    """Return an element; attributes class_, aria_label are written class, aria-label."""
    written = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{escaped(value)}"'
        for key, value in attributes.items()
    )
    return Html(f"<{name}{written}>{join(content)}</{name}>")


def join(parts: Iterable[str], between: str = "") -> Html:
    """Return parts one after another, with markup in between."""
    return Html(between.join(text(part) for part in parts))


def paragraph(*content: str) -> Html:
    """Return a paragraph."""
    return element("p", *content)


def prose(content: str) -> Html:
    """Return the text of a cell of a table that may take several lines."""
    return element("span", content.replace("+-", "±"), class_="prose")


def quiet(*content: str) -> Html:
    """Return a paragraph that qualifies a table."""
    return element("p", *content, class_="quiet")


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


def tile(name: str, value: str, *beside: str) -> Html:
    """Return a figure in large print with its name above it and remarks below it."""
    lines = [("name", name), ("value", value), *(("beside", remark) for remark in beside)]
    return element("div", *(element("span", c, class_=kind) for kind, c in lines), class_="tile")
