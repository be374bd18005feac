"""What an FMU shows to people: icon (lines on a tile, as SVG and as PNG), plugs, documentation."""

from __future__ import annotations

import html
from collections.abc import Sequence
from functools import cache
from io import BytesIO
from xml.etree import ElementTree as ET

from stickslip.fmi.description import writing
from stickslip.models.export.description import Model

Line = Sequence[float]
"""A polyline x1, y1, x2, y2 ... on a tile of 100 by 100, y downwards."""

_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>{title}</title>
<style>
body {{ font: 16px/1.5 sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; }}
pre {{ font: 14px/1.4 monospace; white-space: pre-wrap; }}
</style>
</head>
<body>
<img src="../{icon}" alt="" width="96" height="96">
<pre>{body}</pre>
<h2>Licence</h2>
<p>MIT: <a href="licenses/license.txt">licenses/license.txt</a>. The functions are those of the
Functional Mock-up Interface, whose headers are under the 2-clause BSD licence.</p>
</body>
</html>
"""

_SQUARE = {"x1": 0.0, "y1": 0.0, "x2": 100.0, "y2": 100.0}
_STROKE = 5.0  # of 100
_EDGE, _CORNER = 3.0, 14.0
_TILE, _INK = "#f0f4f8", "#183e60"


def svg(lines: Sequence[Line]) -> str:
    """Return the icon as SVG."""
    paths = "".join(
        f'<polyline points="{" ".join(f"{x:g},{y:g}" for x, y in _points(line))}"/>'
        for line in lines
    )
    inside = 100 - 2 * _EDGE
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100">'
        f'<g fill="none" stroke="{_INK}" stroke-width="{_STROKE:g}"'
        ' stroke-linecap="round" stroke-linejoin="round">'
        f'<rect x="{_EDGE:g}" y="{_EDGE:g}" width="{inside:g}" height="{inside:g}"'
        f' rx="{_CORNER:g}" fill="{_TILE}" stroke-width="{_STROKE / 2:g}"/>'
        f"{paths}</g></svg>\n"
    )


@cache
def png(lines: tuple[Line, ...]) -> bytes:
    """Return the icon as PNG, 128 by 128, with alpha."""
    # In the default style, so that the bytes depend on the version of Matplotlib only.
    from matplotlib import style
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.patches import FancyBboxPatch

    with style.context("default", after_reset=True):
        figure = Figure(figsize=(1.28, 1.28), dpi=100, facecolor="none")
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0, 100), ylim=(100, 0))
        axes.set_axis_off()
        inside, points = 100 - 2 * _EDGE, 1.28 * 72 / 100  # of a printer, in 1/100 of the tile
        axes.add_patch(
            FancyBboxPatch(
                (_EDGE, _EDGE),
                inside,
                inside,
                boxstyle=f"round,pad=0,rounding_size={_CORNER}",
                facecolor=_TILE,
                edgecolor=_INK,
                linewidth=_STROKE / 2 * points,
            )
        )
        for line in lines:
            (drawn,) = axes.plot(line[::2], line[1::2], color=_INK, linewidth=_STROKE * points)
            drawn.set_solid_capstyle("round")
            drawn.set_solid_joinstyle("round")
        picture = BytesIO()
        FigureCanvasAgg(figure).print_png(picture, metadata={"Software": None})  # type: ignore[no-untyped-call]
    return picture.getvalue()


def _points(line: Line) -> list[tuple[float, float]]:
    return list(zip(line[::2], line[1::2], strict=True))


def terminals_and_icons(model: Model) -> str:
    """Return the XML; members of the same name fit each other.

    Source
    ------
    FMI 3.0.2, section 2.6; FMI 2.0.4 takes the same file.
    """
    root = ET.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    picture = writing.child(root, "GraphicalRepresentation")
    writing.child(picture, "CoordinateSystem", **_SQUARE, suggestedScalingFactorTo_mm=0.1)
    writing.child(picture, "Icon", **_SQUARE)
    if model.terminals:
        section = writing.child(root, "Terminals")
        for name, terminal in model.terminals.items():
            element = writing.child(
                section,
                "Terminal",
                name=name,
                matchingRule="plug",
                description=terminal.description,
            )
            for member, variable in terminal.members.items():
                writing.child(
                    element,
                    "TerminalMemberVariable",
                    variableName=variable,
                    memberName=member,
                    variableKind="signal",
                )
    return writing.document(root)


def index(model: Model, icon: str) -> str:
    """Return the page. ``icon`` is its picture's path from the root of the FMU."""
    readme = model.folder / "README.md"
    text = f"# {model.title}\n\n{model.description}\n"
    if readme.exists():
        text = readme.read_text(encoding="utf-8")
    if model.law is not None:
        text += "\n" + (model.law.folder / "README.md").read_text(encoding="utf-8")
    if model.rotary:
        text = "For this rotary drive read rad for m, N m for N and kg m2 for kg.\n\n" + text
    return _PAGE.format(title=html.escape(model.title), icon=icon, body=html.escape(text))
