"""Tables of results: columns are described once, and shown on a terminal, on pages and in files.

    table = Table(
        (
            Column("law", title="law", head="Friction law"),
            Column("error", text=".3g", title="error [N]", head="Error", unit="N", digits=3),
        ),
        rows,
    )
    print(table.text()); table.html(caption); table.records(); table.frame()

A row has values in SI units by the name of their column. A column is not shown where it lacks a
description: without ``text`` not on a terminal, without ``head`` not on a page.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from stickslip.presentation.markup import Html, parts
from stickslip.presentation.quantity import number, percentage
from stickslip.presentation.scale import Scale

Row = Mapping[str, Any]


@dataclass(frozen=True)
class Column:
    """A column of a table."""

    name: str  # of its values in a row, and its key in files
    text: str | Callable[[Row], str] | None = None  # on a terminal: a format of the value, or this
    title: str = ""  # its head on a terminal
    head: str | None = None  # its head on a page
    # what a page shows; by default as ``text`` if a function, else the number, or text as it is
    cell: Callable[[Row], str] | None = None
    digits: int = 4  # significant ones of a number on a page
    unit: str = ""  # with which files state its values
    stored: bool = True  # whether files have it
    words: bool | None = None  # whether it is set to the left; by default unless it is numbers

    def on_terminal(self, row: Row) -> str:
        """Return the value of a row as a terminal shows it; a dash where it is not finite."""
        if callable(self.text):
            return self.text(row)
        value = row.get(self.name)
        return "-" if _plain(value) is None else format(value, self.text or "")

    def on_page(self, row: Row) -> str:
        """Return the value of a row as a page shows it."""
        cell = self.cell or (self.text if callable(self.text) else None)
        value = row.get(self.name) if cell is None else cell(row)
        if value is None or isinstance(value, float):
            return number(math.nan if value is None else value, self.digits)
        return value if isinstance(value, str) else str(value)

    def in_file(self, row: Row) -> object:
        """Return the value of a row as plain data, with its unit where that is stated."""
        value = _plain(row.get(self.name))
        return {"value": value, "unit": self.unit} if self.unit else value


def share(name: str, head: str, unit: str = "") -> Column:
    """Return a column of shares in per cent."""

    def shown(row: Row) -> str:
        return f"{100.0 * row[name]:.3g} %"

    return Column(
        name, shown, head.lower(), head, cell=lambda row: percentage(row[name]), unit=unit
    )


def scaled(name: str, scale: Callable[[Row], Scale], head: str, text: str | None = None) -> Column:
    """Return a column in the unit in which it reads best, on a terminal, too, unless formatted."""

    def shown(row: Row) -> str:
        return number(scale(row).factor * row[name], 3)

    return Column(name, text or shown, head.lower(), head, cell=shown)


def units(scale: Callable[[Row], Scale]) -> Column:
    """Return the column of these units."""
    return Column("unit", lambda row: scale(row).unit, head="", stored=False)


@dataclass(frozen=True)
class Table:
    """Columns and rows."""

    columns: Sequence[Column]
    rows: Sequence[Row]

    @classmethod
    def of(cls, columns: Sequence[Column], frame: pd.DataFrame) -> "Table":
        """Return a table with the rows of a DataFrame."""
        rows: Any = frame.to_dict("records")
        return cls(columns, rows)

    def text(self) -> str:
        """Return the lines of a terminal; words are set to the left, numbers to the right."""
        shown = [column for column in self.columns if column.text is not None]
        lines = [[column.on_terminal(row) for column in shown] for row in self.rows]
        if any(column.title for column in shown):
            lines.insert(0, [column.title for column in shown])
        widths = [max(map(len, cells)) for cells in zip(*lines, strict=True)]
        marks = [">" if self._is_number(column) else "<" for column in shown]
        return "\n".join(
            "  ".join(map("{:{}{}}".format, line, marks, widths)).rstrip() for line in lines
        )

    def html(self, caption: str) -> Html:
        """Return the table of a page."""
        shown = [column for column in self.columns if column.head is not None]
        words = [i for i, column in enumerate(shown) if not self._is_number(column)]
        cells = [[column.on_page(row) for column in shown] for row in self.rows]
        return Html(parts.table([one.head or "" for one in shown], cells, caption, words))

    def records(self) -> list[dict[str, object]]:
        """Return the rows as plain data; a number that is not finite is None."""
        return [
            {column.name: column.in_file(row) for column in self.columns if column.stored}
            for row in self.rows
        ]

    def by_key(self) -> dict[str, dict[str, object]]:
        """Return the rows as plain data, by the value of the first column."""
        key = self.columns[0].name
        return {str(row.pop(key)): row for row in self.records()}

    def frame(self) -> pd.DataFrame:
        """Return the rows as a DataFrame."""
        names = [column.name for column in self.columns if column.stored]
        return pd.DataFrame([{n: row.get(n) for n in names} for row in self.rows], columns=names)

    def _is_number(self, column: Column) -> bool:
        if column.words is not None:
            return not column.words
        kinds = {type(row.get(column.name)) for row in self.rows}
        return any(issubclass(kind, (int, float)) and kind is not bool for kind in kinds)


def _plain(value: object) -> object:
    return None if isinstance(value, float) and not math.isfinite(value) else value
