"""What a run recorded."""

from __future__ import annotations

import csv
import io
import math
import operator
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stickslip.cosim import kernel
from stickslip.cosim.display import html_table
from stickslip.cosim.signals.signals import Array
from stickslip.cosim.system.system import System
from stickslip.fmi.files import atomic_file
from stickslip.fmi.messages import scaled_unit, suggestion

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

Changes = Mapping[str, Sequence[tuple[float, str]]]
"""Name of a variable -> times (s) and what it holds from each on."""
_HEIGHT, _WIDTH, _PANEL = 1.0, 7.0, 2.0
"""Of a figure without panels, its width, and the height of a panel [inch]."""
_NUMBERS = 100_000  # of a CSV file that are formatted at the same time


class Result:
    """Signals over time; ``result["drive.v"]`` is an array (n,) float64.

    Where only one component has a variable ``v``, ``result["v"]`` is the same array.

    Attributes
    ----------
    time : (n,) float64, s; n is n_steps + 1 unless the record says otherwise
    points : how many points in time the values are of: n, or those of a range
    stopped : who asked to end the run before its time and when; None where the run is whole
    names : of the signals
    values : (n, len(names)) float64, each in its unit; put in order when asked for as a whole
    rows : the same as the kernel has them, with the signals at ``places``, by default in order
    changes : variable of type String -> times (s) and what it holds from each on
    texts : the same by points: what it holds at each, n of them
    """

    def __init__(
        self,
        time: Array,
        rows: Array,
        names: Sequence[str],
        system: System,
        stopped: str | None = None,
        changes: Changes | None = None,
        points: int | None = None,
        places: Sequence[int] | None = None,
    ) -> None:
        self.points = len(time) if points is None else points
        self.stopped = stopped
        self.time = time
        self.rows, self._places = rows, places
        self.names = tuple(names)
        self.changes = changes or {}
        self._system = system

    def __getitem__(self, name: str) -> Array:
        if not isinstance(name, str):
            raise self._unknown(name)
        if (column := self._column(name)) is not None:
            return self._signal(column)
        if (array := self._array(name)) is not None:
            return array
        raise self._unknown(name)

    @cached_property
    def values(self) -> Array:
        """The signals, in the order of their names."""
        return self._part(slice(None))

    def _part(self, points: slice) -> Array:
        return self.rows[points] if self._places is None else self.rows[points, self._places]

    def _signal(self, column: int) -> Array:
        return self.rows[:, column if self._places is None else self._places[column]]

    def _unknown(self, name: object) -> KeyError:
        """Return what is wrong with a name that is no column."""
        if not isinstance(name, str):
            return KeyError(f"{name!r}: expected the name of one signal")
        if same := [known for known in self.names if known.endswith(f".{name}")]:
            return KeyError(f"{name!r} was recorded of several components: {', '.join(same)}")
        return KeyError(f"{name!r} was not recorded{suggestion(name, self.names)}")

    def _array(self, name: str) -> Array | None:
        """Return an array of which all elements were recorded, (n, *dimensions)."""
        if not any(known.startswith(f"{name}[") for known in self.names):
            return None
        variable = self._system.variable(name)
        prefix = name.removesuffix(variable.name)
        elements = [prefix + element.name for element in variable.elements()]
        if not all(name in self for name in elements):
            return None
        columns = [self._columns[name] for name in elements]
        return self.values[:, columns].reshape(-1, *variable.dimensions)

    def __contains__(self, name: object) -> bool:
        return self._column(name) is not None

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)

    def __repr__(self) -> str:
        signals = ", ".join(f"{name} [{unit or ''}]" for name, unit in self.units.items())
        return f"Result({len(self.time)} points: {signals})"

    def _repr_html_(self) -> str:
        time, rows = self.time, []
        for name, values in zip(self.names, self.values.T, strict=True):
            some = (values.min(), values.max(), values[-1]) if len(time) else ()
            rows.append((name, self.units[name] or "", *(f"{x:.6g}" for x in some)))
        caption = f"{len(time)} points" + (f", {time[0]:g} to {time[-1]:g} s" if len(time) else "")
        caption += f"; ended by {self.stopped}" if self.stopped else ""
        return html_table(("signal", "unit", "least", "greatest", "last"), rows, caption, words=2)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.names)

    def plot(self, *names: str, axes: Axes | Sequence[Axes] | None = None) -> list[Axes]:
        """Draw signals over time with matplotlib, those of one unit in one panel; return axes.

        Values and time are shown in the SI prefix that makes numbers between 1 and 1000 of them. By
        default all signals are drawn, into a new figure; ``axes`` has one for each unit, in the
        order of the names. KeyError when a signal was not recorded.
        """
        columns = [*map(self._column, names)] if names else range(len(self.names))
        chosen = {}
        for name, column in zip(names or self.names, columns, strict=True):
            if column is None:
                raise self._unknown(name)
            chosen[self.names[column]] = self._signal(column)
        return _draw(self.time, chosen, self.units, axes)

    @cached_property
    def texts(self) -> dict[str, list[str]]:
        """What each variable of type String holds at the points in time."""
        found = {}
        for name, course in self.changes.items():
            places = np.searchsorted([t for t, _ in course], self.time, "right")
            found[name] = [course[i - 1][1] for i in places]
        return found

    @cached_property
    def units(self) -> dict[str, str | None]:
        """Unit of each signal; None where its FMU gives none."""
        return {name: self._system.unit(name) for name in self.names}

    def frame(self) -> pd.DataFrame:
        """Return signals, then strings, by time (s); ``attrs["units"]`` holds the units."""
        import pandas as pd  # late, for those who start quickly

        index = pd.Index(self.time, name="time")
        frame = pd.DataFrame(self.values, index=index, columns=list(self.names))
        for name, texts in self.texts.items():
            frame[name] = texts
        frame.attrs["units"] = self.units
        return frame

    def to_csv(self, path: str | os.PathLike[str]) -> Path:
        """Write ``time`` (s) and the signals, names in the first line, every digit kept."""
        with writing(Path(path)) as take:
            take(self)
        return Path(path)

    def lines(self) -> Iterator[bytes | memoryview]:
        """Yield the lines of a CSV file but for the first, many at a time."""
        n = max(1, _NUMBERS // (1 + len(self.names)))
        for i in range(0, len(self.time), n):
            points = slice(i, i + n)
            time, rows = self.time[points], self._part(points)
            if self.texts:
                texts = zip(*(text[points] for text in self.texts.values()), strict=True)
                numbers = np.column_stack([time, rows]).tolist()
                yield _lines(map(operator.add, numbers, map(list, texts)))
            else:
                yield kernel.lines_of(time, rows)

    def range(self, earlier: Result | None = None) -> Result:
        """Return the least, the greatest and the last values, of an earlier part too."""
        parts = [part for part in (earlier, self) if part and len(part.time)]
        time, rows = self.time, self.rows
        if parts:
            time = np.array([parts[0].time[0], parts[-1].time[-1], parts[-1].time[-1]])
            rows = _reduced(np.vstack([_reduced(part.rows) for part in parts]))
        changes = {
            name: list(dict.fromkeys([*course[:1], *self.changes[name][-1:]]))
            for name, course in (earlier or self).changes.items()
        }
        points = sum(part.points for part in parts)
        return Result(time, rows, self.names, self._system, self.stopped, changes, points)

    def to_parquet(self, path: str | os.PathLike[str]) -> Path:
        """Write ``time`` (s) and the signals with their units; CosimError without pyarrow."""
        from stickslip.cosim.signals.tables import write_parquet

        write_parquet(Path(path), self.frame(), self.units)
        return Path(path)

    def to_excel(self, path: str | os.PathLike[str]) -> Path:
        """Write a sheet of ``time`` (s) and the signals; CosimError without room or openpyxl."""
        from stickslip.cosim.signals.tables import write_excel

        write_excel(Path(path), self.frame())
        return Path(path)

    def _column(self, name: object) -> int | None:
        return self._columns.get(name) if isinstance(name, str) else None

    @cached_property
    def _columns(self) -> dict[str, int]:
        """The column of each signal, by its name, and by that of a variable that only one has."""
        found: dict[str, list[int]] = {}
        for column, name in enumerate(self.names):
            found.setdefault(name.partition(".")[2], []).append(column)
        short = {name: columns[0] for name, columns in found.items() if name and len(columns) == 1}
        return short | {name: column for column, name in enumerate(self.names)}


def _lines(rows: Iterable[Sequence[object]]) -> bytes:
    """Return rows as lines of a CSV file."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue().encode()


Take = Callable[[Result], object]
"""Takes a result part by part."""


@contextmanager
def writing(path: Path) -> Iterator[Take]:
    """Write a CSV file part by part; it has its name when all is written.

    A run that has to begin again takes back what was written.
    """
    with atomic_file(path) as file:
        last = -math.inf

        def take(part: Result) -> None:
            nonlocal last
            if last == -math.inf or (part.time[:1] <= last).any():
                file.seek(0)
                file.truncate()
                file.write(_lines([["time", *part.names, *part.changes]]))
            file.writelines(part.lines())
            last = max(part.time[-1:], default=last)

        yield take


def taking(out: str | os.PathLike[str] | Take | None) -> AbstractContextManager[Take | None]:
    """Return what takes parts: a function as it is, a file as one that writes it."""
    return nullcontext(out) if out is None or callable(out) else writing(Path(out))


def _reduced(rows: Array) -> Array:
    """Return the least, the greatest and the last values (3, n) of rows; NaN stays."""
    by_column = [[column.min(), column.max(), column[-1]] for column in rows.T]
    return np.array(by_column).reshape(-1, 3).T


def _draw(
    time: Array,
    signals: Mapping[str, Array],
    units: Mapping[str, str | None],
    axes: Axes | Sequence[Axes] | None,
) -> list[Axes]:
    panels: dict[str | None, list[str]] = {}
    for name in signals:
        panels.setdefault(units[name], []).append(name)
    if axes is None:
        from matplotlib import pyplot as plt  # late, for those who only simulate

        size = (_WIDTH, _HEIGHT + _PANEL * len(panels))
        figure, grid = plt.subplots(
            len(panels), sharex=True, squeeze=False, figsize=size, layout="constrained"
        )
        figure.align_ylabels()
    else:
        grid = np.atleast_1d(np.asarray(axes, dtype=object))
    given: list[Axes] = list(grid.ravel())
    if len(given) != len(panels):
        raise ValueError(f"expected axes for {len(panels)} units, got {len(given)}")
    seconds, of_time = scaled_unit("s", float(np.abs(time).max(initial=0.0)))
    for panel, (unit, names) in zip(given, panels.items(), strict=True):
        sizes = [np.abs(signals[name][np.isfinite(signals[name])]) for name in names]
        factor, shown = scaled_unit(unit, max(float(size.max(initial=0.0)) for size in sizes))
        for name in names:
            panel.plot(seconds * time, factor * signals[name], label=name, linewidth=1.2)
        if len(names) > 1:
            panel.legend()
        panel.set_ylabel(f"{names[0]} [{shown}]" if len(names) == 1 else f"[{shown}]")
        panel.grid(visible=True, alpha=0.3)
    given[-1].set_xlabel(f"time [{of_time}]")
    return given
