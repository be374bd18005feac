"""Block diagrams: blocks, sums and arrows on a sheet measured in mm."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, Polygon, Rectangle

from stickslip.presentation.style import GREY, INK, LINE, PALE, SMALL

Point = tuple[float, float]
RADIUS = 2.4  # Of a summing point [mm]


@dataclass(frozen=True)
class Block:
    """A box with its middle at (x, y), all in mm, and the middles of its sides."""

    x: float
    y: float
    width: float
    height: float = 12.0

    @property
    def left(self) -> Point:  # noqa: D102
        return self.x - self.width / 2, self.y

    @property
    def right(self) -> Point:  # noqa: D102
        return self.x + self.width / 2, self.y

    @property
    def top(self) -> Point:  # noqa: D102
        return self.x, self.y + self.height / 2

    @property
    def bottom(self) -> Point:  # noqa: D102
        return self.x, self.y - self.height / 2


class Sheet:
    """Axes that cover a whole figure, in mm from its lower left corner."""

    def __init__(self, figure: Figure) -> None:
        width, height = (25.4 * float(side) for side in figure.get_size_inches())
        self.axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        self.axes.set_axis_off()
        self.axes.set(xlim=(0.0, width), ylim=(0.0, height))

    def block(self, block: Block, label: str, note: str = "", fill: str = "white") -> Block:
        """Draw a block with a label and, below it, a note of one line or more in small print."""
        corner = (block.left[0], block.bottom[1])
        outline: Any = {"facecolor": fill, "edgecolor": INK, "lw": LINE}
        self.axes.add_patch(Rectangle(corner, block.width, block.height, **outline))
        return self._labelled(block, label, note)

    def decision(self, block: Block, label: str, note: str = "") -> Block:
        """Draw a rhombus as wide and as high as a block, with a label and a note."""
        corners = [block.top, block.right, block.bottom, block.left]
        self.axes.add_patch(Polygon(corners, facecolor="white", edgecolor=INK, lw=LINE))
        return self._labelled(block, label, note)

    def group(self, corner: Point, width: float, height: float, label: str) -> None:
        """Draw a dashed frame around what belongs together, named at its upper left."""
        self.axes.add_patch(
            Rectangle(corner, width, height, facecolor=PALE, edgecolor=GREY, ls=(0, (4, 3)), lw=0.7)
        )
        self.text((corner[0] + 2, corner[1] + height - 3.2), label, small=True, align="left")

    def sum(self, at: Point, left: str = "", above: str = "", below: str = "") -> Block:
        """Draw a summing point with the signs of the lines that reach it from each side."""
        self.axes.add_patch(Circle(at, RADIUS, facecolor="white", edgecolor=INK, lw=LINE))
        self.text((at[0] - 3.6, at[1] + 3.0), left)
        self.text((at[0] + 2.6, at[1] + 4.2), above)
        self.text((at[0] + 2.6, at[1] - 4.2), below)
        return Block(*at, 2 * RADIUS, 2 * RADIUS)

    def node(self, at: Point) -> None:
        """Draw the dot where a line branches."""
        self.axes.add_patch(Circle(at, 0.7, facecolor=INK, edgecolor=INK))

    def chain(self, *parts: Block | Point) -> None:
        """Draw arrows from part to part, from left to right; a point is an end of a line."""
        for one, next_ in pairwise(parts):
            self.arrow(
                one.right if isinstance(one, Block) else one,
                next_.left if isinstance(next_, Block) else next_,
            )

    def arrow(self, *points: Point) -> None:
        """Draw a line through points with a head at the last."""
        if len(points) > 2:
            xs, ys = zip(*points[:-1], strict=True)
            self.axes.plot(xs, ys, color=INK, lw=LINE, solid_capstyle="butt")
        head = "-|>,head_length=3.2,head_width=1.5"
        look: Any = {"mutation_scale": 1.0, "lw": LINE, "color": INK, "joinstyle": "miter"}
        arrow = FancyArrowPatch(*points[-2:], arrowstyle=head, shrinkA=0, shrinkB=0, **look)
        self.axes.add_patch(arrow)

    def _labelled(self, block: Block, label: str, note: str) -> Block:
        further = note.count("\n")
        lift = 2.1 + 1.7 * further if note else 0.0
        self.text((block.x, block.y + lift), label)
        self.text((block.x, block.y - 2.7 + 0.1 * further), note, small=True)
        return block

    def text(self, at: Point, content: str, *, small: bool = False, align: str = "center") -> None:
        """Write a text, unless it is empty, with its middle (or its left end) at a point."""
        if not content:
            return
        size = SMALL if small else None
        ha = "left" if align == "left" else "center"
        self.axes.text(*at, content, ha=ha, va="center", fontsize=size, linespacing=1.35)
