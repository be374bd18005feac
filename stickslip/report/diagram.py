"""Block diagrams: blocks, sums and arrows on a sheet measured in mm."""

from __future__ import annotations

from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, Polygon, Rectangle

from stickslip.report.style import GREY, INK, LINE, PALE, SMALL

Point = tuple[float, float]
RADIUS = 2.4
"""Of a summing point [mm]."""


@dataclass(frozen=True)
class Block:
    """A box with its middle at (x, y), all in mm."""

    x: float
    y: float
    width: float
    height: float = 12.0

    @property
    def left(self) -> Point:
        """Middle of the left side."""
        return self.x - self.width / 2, self.y

    @property
    def right(self) -> Point:
        """Middle of the right side."""
        return self.x + self.width / 2, self.y

    @property
    def top(self) -> float:
        """Height of the upper side."""
        return self.y + self.height / 2

    @property
    def bottom(self) -> float:
        """Height of the lower side."""
        return self.y - self.height / 2


class Sheet:
    """Axes that cover a whole figure, in mm from its lower left corner."""

    def __init__(self, figure: Figure) -> None:
        width, height = (25.4 * float(side) for side in figure.get_size_inches())
        self.axes: Axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        self.axes.set_axis_off()
        self.axes.set_xlim(0.0, width)
        self.axes.set_ylim(0.0, height)

    def block(self, block: Block, label: str, note: str = "", fill: str = "white") -> Block:
        """Draw a block with a label and, below it, a note of one line or more in small print."""
        corner = (block.left[0], block.bottom)
        self.axes.add_patch(
            Rectangle(corner, block.width, block.height, facecolor=fill, edgecolor=INK, lw=LINE)
        )
        self._labelled(block, label, note)
        return block

    def decision(self, block: Block, label: str, note: str = "") -> Block:
        """Draw a rhombus as wide and as high as a block, with a label and a note."""
        corners = [(block.x, block.top), block.right, (block.x, block.bottom), block.left]
        self.axes.add_patch(Polygon(corners, facecolor="white", edgecolor=INK, lw=LINE))
        self._labelled(block, label, note)
        return block

    def group(self, corner: Point, width: float, height: float, label: str) -> None:
        """Draw a dashed frame around what belongs together, named at its upper left."""
        self.axes.add_patch(
            Rectangle(corner, width, height, facecolor=PALE, edgecolor=GREY, ls=(0, (4, 3)), lw=0.7)
        )
        self.text((corner[0] + 2, corner[1] + height - 3.2), label, small=True, align="left")

    def sum(self, at: Point) -> Point:
        """Draw a summing point; signs are texts beside it."""
        self.axes.add_patch(Circle(at, RADIUS, facecolor="white", edgecolor=INK, lw=LINE))
        return at

    def node(self, at: Point) -> None:
        """Draw the dot where a line branches."""
        self.axes.add_patch(Circle(at, 0.7, facecolor=INK, edgecolor=INK))

    def arrow(self, *points: Point) -> None:
        """Draw a line through points with a head at the last."""
        if len(points) > 2:
            xs, ys = zip(*points[:-1], strict=True)
            self.axes.plot(xs, ys, color=INK, lw=LINE, solid_capstyle="butt")
        self.axes.add_patch(
            FancyArrowPatch(
                points[-2],
                points[-1],
                arrowstyle="-|>,head_length=3.2,head_width=1.5",
                mutation_scale=1.0,
                shrinkA=0,
                shrinkB=0,
                lw=LINE,
                color=INK,
                joinstyle="miter",
            )
        )

    def _labelled(self, block: Block, label: str, note: str) -> None:
        further = note.count("\n")
        lift = 2.1 + 1.7 * further if note else 0.0
        self.text((block.x, block.y + lift), label)
        if note:
            self.text((block.x, block.y - 2.7 + 0.1 * further), note, small=True)

    def text(self, at: Point, content: str, *, small: bool = False, align: str = "center") -> None:
        """Write a text with its middle (or its left end) at a point."""
        self.axes.text(
            *at,
            content,
            ha="left" if align == "left" else "center",
            va="center",
            fontsize=SMALL if small else None,
            linespacing=1.35,
        )
