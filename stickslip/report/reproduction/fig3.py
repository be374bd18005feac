"""Fig. 3: the learning scheme. What the drive does with a compensator, and what it should do."""

from __future__ import annotations

from matplotlib.figure import Figure

from stickslip.pipeline.reproduction import Reproduction
from stickslip.report.diagram import (
    RADIUS,
    Block,
    Sheet,
)
from stickslip.report.style import (
    PAGE,
    PALE,
    new_figure,
)

HEIGHT = 80.0


def draw(reproduction: Reproduction) -> Figure:
    """Draw the scheme with the algorithm of this run, and what its compensator is driven by."""
    figure = new_figure(PAGE, HEIGHT, free=True)
    sheet = Sheet(figure)
    low, middle, high = 15.0, 40.0, 69.0
    sheet.group((37, 2), 52, 50, "")
    sheet.text((63, 5.2), "Velocity loop with compensator, Fig. 2(a)", small=True)
    nominal = sheet.block(
        Block(36, high, 42), "Nominal velocity loop", "without friction, Fig. 2(b)", PALE
    )
    compensator = sheet.block(Block(63, middle, 40), "Friction compensator", "LuGre (2)–(4)", PALE)
    drive = sheet.block(Block(63, low, 40), "Velocity loop", "drive with friction")
    title = reproduction.algorithm.title.removeprefix("a ")
    learner = sheet.block(
        Block(122, middle, 32, 14), title[0].upper() + title[1:], "Steps 1 to 4, Fig. 4", PALE
    )
    cost = sheet.block(Block(157, middle, 23, 14), "Cost (6)", r"$1/J = \sum (v - v_r)^2$")
    gap = sheet.sum((177, middle))

    branch = (9.0, high)
    sheet.arrow((3, high), nominal.left)
    sheet.arrow(branch, (branch[0], low), drive.left)
    sheet.arrow(nominal.right, (gap[0], high), (gap[0], middle + RADIUS))
    sheet.arrow(drive.right, (gap[0], low), (gap[0], middle - RADIUS))
    if reproduction.options.feed == "nominal":
        tap = (compensator.x, high)
        sheet.arrow(tap, (compensator.x, compensator.top))
    else:
        tap = (branch[0], middle)
        sheet.arrow(tap, compensator.left)
    sheet.arrow((compensator.x, compensator.bottom), (drive.x, drive.top))
    sheet.arrow((gap[0] - RADIUS, middle), cost.right)
    sheet.arrow(cost.left, learner.right)
    sheet.arrow(learner.left, compensator.right)

    for at in (branch, tap):
        sheet.node(at)
    for at, said in (
        ((4.5, high + 3.0), r"$v_{cmd}$"),
        ((130, high + 3.0), r"$v_r$"),
        ((130, low + 3.0), r"$v$"),
        ((compensator.x + 4.5, (compensator.bottom + drive.top) / 2), r"$F_{ff}$"),
        ((gap[0] - 3.6, middle + 4.4), "−"),
        ((gap[0] - 3.6, middle - 4.4), "+"),
        ((97.5, middle + 3.2), r"$F_s,\,F_c,\,v_s$"),
        ((97.5, middle - 3.4), r"$\sigma_0,\,\sigma_1$"),
    ):
        sheet.text(at, said)
    return figure
