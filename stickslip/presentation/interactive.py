"""Figures as data that a page draws again when it is asked to, to zoom and to read values from.

The page contains BokehJS, compressed, and loads it when the first figure is opened. Without
scripts, in print, and where neither the wheel nor the package ``bokeh`` brings it, the page shows
its pictures alone.
"""

import base64
import gzip
import json
import re
import unicodedata
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, FuncFormatter

from stickslip.presentation.markup import Html
from stickslip.servo.measurement import Array

CARRIED = Path(__file__).with_name("bokeh.js.gz")  # what ``precompile`` writes for a wheel
LEAST = 50  # Points of a line from which on its panel is worth opening
DIGITS = 6
Panel = dict[str, Any]
_kept: WeakKeyDictionary[Line2D, tuple[Array, Array]] = WeakKeyDictionary()
_named: WeakKeyDictionary[Line2D, list[str]] = WeakKeyDictionary()


def keep(line: Line2D, x: Array, y: Array) -> None:
    """Let a line that a picture shows thinned open with more points (n,)."""
    _kept[line] = (x, y)


def name_points(line: Line2D, names: Iterable[str]) -> None:
    """Let the points of a line (n,) show these names where the figure is opened."""
    _named[line] = list(names)


def panels(figure: Figure) -> list[Panel]:
    """Return the panels with long lines or named points; linked ones have the same ``link``."""
    shown = [
        axes
        for axes in figure.axes
        if axes.name == "rectilinear"
        and any(one in _named or np.size(one.get_xdata()) >= LEAST for one in _lines(axes))
    ]
    return [_panel(axes, shown) for axes in shown]


def scripts(figures: Mapping[str, list[Panel]]) -> Html:
    """Return the elements with which a page opens figures, by name; none without BokehJS."""
    if not (figures and (library := bokeh())):
        return Html("")
    code = files(__package__).joinpath("interactive.js").read_text(encoding="utf-8")
    data = json.dumps(figures, separators=(",", ":"), allow_nan=False)
    parts = [
        f'<script type="application/gzip" id="{name}">{base64.b64encode(packed).decode()}</script>'
        for name, packed in (("bokeh", library), ("plots", gzip.compress(data.encode(), mtime=0)))
    ]
    return Html("\n".join([*parts, f'<script type="module">\n{code}</script>']))


@cache
def bokeh() -> bytes:
    """Return BokehJS, compressed: as the wheel carries it, or the package; empty without both."""
    if CARRIED.exists():
        return CARRIED.read_bytes()
    if find_spec("bokeh") is None:
        return b""
    folder = files("bokeh").joinpath("server/static/js")
    names = ("bokeh.min.js", "bokeh-api.min.js")
    return gzip.compress(b"".join(folder.joinpath(name).read_bytes() for name in names), mtime=0)


def _lines(axes: Axes) -> list[Line2D]:
    """Return the lines in data coordinates."""
    return [
        one
        for one in axes.get_lines()
        if one.get_transform() == axes.transData and one.get_visible()
    ]


def _panel(axes: Axes, shown: list[Axes]) -> Panel:
    joined = axes.get_shared_x_axes().joined
    linked = (k for k, other in enumerate(shown) if other is axes or joined(axes, other))
    return {
        "title": plain(axes.get_title(loc="left") or axes.get_title()),
        "link": next(linked),
        "x": _axis(axes.xaxis),
        "y": _axis(axes.yaxis),
        "lines": [_line(one) for one in _lines(axes)],
    }


def _axis(axis: Axis) -> Panel:
    """Return label, scale, range, and the labels of ticks that are words."""
    words, formatter = {}, axis.get_major_formatter()
    if isinstance(axis.get_major_locator(), FixedLocator) and isinstance(formatter, FuncFormatter):
        places = [float(place) for place in axis.get_majorticklocs()]
        words = dict(zip(places, formatter.format_ticks(places), strict=True))
    return {
        "label": plain(axis.get_label_text()),
        "scale": axis.get_scale(),
        "range": list(axis.get_view_interval()),
        "words": words,
    }


def _line(line: Line2D) -> Panel:
    """Return a line; where it is not finite, it has a gap."""
    shown = _kept.get(line, line.get_data())
    x, y = (np.ravel(np.asarray(values, dtype=float)) for values in shown)
    label, marker = str(line.get_label()), str(line.get_marker())
    return {
        "label": "" if label.startswith("_") else plain(label),
        "colour": to_hex(line.get_color()),
        "joined": line.get_linestyle() not in ("None", "", " "),
        "dashed": line.get_linestyle() == "--",
        "mark": marker if marker not in ("None", " ") else "",
        "x": _rounded(x),
        "y": _rounded(y),
        "names": _named.get(line, []),
    }


def _rounded(values: Array) -> list[float | None]:
    return [float(f"{one:.{DIGITS}g}") if np.isfinite(one) else None for one in values]


def plain(text: str) -> str:
    """Return a label without the marks of mathematical text."""

    def letter(found: re.Match[str]) -> str:
        try:
            return unicodedata.lookup(f"GREEK SMALL LETTER {found[1]}")
        except KeyError:
            return found[1]

    text = re.sub(r"\\([a-z]+)", letter, text)
    return re.sub(r"[${}]", "", text.replace("^2", "²"))
