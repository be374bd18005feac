"""The icon of a model: lines of model.toml on a tile, as SVG and as PNG."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from io import BytesIO

Line = Sequence[float]
"""A polyline x1, y1, x2, y2 ... on a tile of 100 by 100, y downwards."""

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
