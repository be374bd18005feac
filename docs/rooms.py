"""``make rooms``: draw the rooms of ``stickslip/`` with their sizes and what each imports.

Rooms stand in the order that ``tests/test_architecture.py`` holds, the ground at the bottom. A blue
arc means that the upper room imports the lower one; a red one would be an arrow that runs back up.
The picture of another commit is drawn in a checkout of it.
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

import matplotlib as mpl

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))
mpl.use("agg")

from matplotlib import pyplot as plt  # noqa: E402 - after the choice of how to draw
from matplotlib.patches import Arc  # noqa: E402 - the same

from tests.test_architecture import (  # noqa: E402 - of the tests
    ROOMS_OF_STICKSLIP,
    nodes,
    room_of,
    sources,
    targets,
)

OUT = ROOT / "docs" / "_build" / "rooms.png"


def main() -> None:
    """Draw, and print sizes and numbers of imports."""
    own = {module: tree for module, tree in sources().items() if room_of(module)}
    arrows: Counter[tuple[str, str]] = Counter()
    lines: Counter[str] = Counter()
    for module, tree in own.items():
        here = room_of(module)
        lines[here] += max((getattr(node, "end_lineno", 0) for node in tree.body), default=0)
        found = (name for node in nodes(tree) for name in targets(node) if name in own)
        arrows.update((here, room_of(name)) for name in found if room_of(name) != here)
    place = {room: i for i, room in enumerate(ROOMS_OF_STICKSLIP)}
    figure, axes = plt.subplots(figsize=(9.0, 10.0))
    most = max(lines.values())
    for room, i in place.items():
        axes.barh(i, -lines[room] / most, 0.7, color="#c9d7e8")
        axes.text(-0.01, i, f"{room}  {lines[room]}", ha="right", va="center", fontsize=8)
    for (above, below), n in arrows.items():
        up, size = place[below] > place[above], abs(place[above] - place[below])
        middle = 0.5 * (place[above] + place[below])
        arc = Arc((0.0, middle), 0.12 * size, size, theta1=-90.0, theta2=90.0)
        arc.set(color="#c02020" if up else "#20508f", alpha=0.5, linewidth=0.4 + 0.15 * n**0.5)
        axes.add_patch(arc)
    axes.set(xlim=(-1.05, 2.6), ylim=(-0.7, len(place) - 0.3))
    axes.axis("off")
    OUT.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(OUT, dpi=110, bbox_inches="tight")
    back = sum(place[below] > place[above] for above, below in arrows)
    print(f"{len(place)} rooms, {len(arrows)} arrows, {back} of them back up")
    for room in reversed(ROOMS_OF_STICKSLIP):
        below = sorted(b for a, b in arrows if a == room)
        print(f"{lines[room]:6} {room:16} {' '.join(below)}")
    print(OUT)


if __name__ == "__main__":
    main()
