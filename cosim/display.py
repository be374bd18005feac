"""Tables that notebooks show."""

from collections.abc import Iterable, Sequence

from stickslip.fmi.messages import escaped

_LEFT = ' style="text-align:left"'


def html_table(
    heads: Sequence[str], rows: Iterable[Sequence[object]], caption: str = "", *, words: int = 0
) -> str:
    """Return a table as HTML; the first columns are words, the others numbers."""

    def line(cells: Sequence[object], kind: str) -> str:
        looks = (_LEFT if column < words else "" for column in range(len(cells)))
        pairs = zip(cells, looks, strict=True)
        row = "".join(f"<{kind}{look}>{escaped(str(c))}</{kind}>" for c, look in pairs)
        return f"<tr>{row}</tr>"

    body = "\n".join(line(cells, "td") for cells in rows)
    title = f"<caption{_LEFT}>{escaped(caption)}</caption>\n" if caption else ""
    head = f"<thead>{line(heads, 'th')}</thead>"
    return f"<table>\n{title}{head}\n<tbody>\n{body}\n</tbody>\n</table>"
