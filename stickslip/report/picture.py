"""A drawn figure as the bytes of its files."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from matplotlib.figure import Figure

from stickslip.report.style import RESOLUTION, house_style

MILLIMETRES = 25.4
"""In an inch, matplotlib's unit."""


def picture_files(names: Iterable[str]) -> list[str]:
    """Return the names of the files of pictures."""
    return [f"{name}.{kind}" for name in names for kind in ("png", "svg")]


@dataclass(frozen=True)
class Picture:
    """One figure.

    Attributes
    ----------
    png, svg : contents of the files, without dates and so the same each time
    width : [mm]
    """

    png: bytes
    svg: bytes
    width: float

    @classmethod
    def of(cls, draw: Callable[..., Figure], *subjects: object) -> Picture:
        """Draw a figure of its subjects in the house style."""
        with house_style():
            figure = draw(*subjects)
            _settle(figure)
            png, svg = io.BytesIO(), io.BytesIO()
            figure.savefig(png, format="png", dpi=RESOLUTION, metadata={"Software": None})
            figure.savefig(svg, format="svg", metadata={"Date": None, "Creator": None})
        width = float(figure.get_figwidth()) * MILLIMETRES
        return cls(png.getvalue(), svg.getvalue(), width)

    def embedded(self) -> str:
        """Return the picture as a data URI, which needs no further file.

        As an image of its own its ids and styles do not meet those of the page.
        """
        return "data:image/svg+xml;base64," + base64.b64encode(self.svg).decode("ascii")


def _settle(figure: Figure) -> None:
    """Place the axes for good, to six digits: the layout's solver varies in the last ones."""
    if figure.get_layout_engine() is None:
        return
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    for axes in figure.axes:
        left, bottom, width, height = (round(side, 6) for side in axes.get_position().bounds)
        axes.set_position((left, bottom, width, height))
