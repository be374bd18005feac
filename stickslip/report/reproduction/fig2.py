"""Fig. 2: the compensated loop (a), the nominal loop (b), and its step response (c)."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.figure import Figure

from stickslip.pipeline.reproduction import Reproduction
from stickslip.report.diagram import (
    RADIUS,
    Block,
    Sheet,
)
from stickslip.report.quantity import number
from stickslip.report.style import (
    FAINT,
    PAGE,
    PALE,
    SHADE,
    SMALL,
    WITH,
    name_panel,
    new_figure,
)
from stickslip.servo.systems import Feed
from stickslip.servo.velocity_loop import VelocityLoop

HEIGHT = 127.0
CONTROL = r"$K_p + K_i T_s \, z/(z-1)$"
ESTIMATE = r"difference, low-pass $\tau_f$"


def draw(reproduction: Reproduction) -> Figure:
    """Draw the loops with the numbers of this design."""
    loop = reproduction.identification.loop
    return draw_loops(loop, reproduction.truth, reproduction.options.feed)


def draw_loops(loop: VelocityLoop, truth: Mapping[str, float], feed: Feed) -> Figure:
    """Draw a loop around a drive whose parameters are ``truth``."""
    figure = new_figure(PAGE, HEIGHT, free=True)
    sheet = Sheet(figure)
    _compensated(sheet, truth, feed)
    _nominal(sheet, loop)
    _step(figure, loop)
    return figure


def _compensated(sheet: Sheet, truth: Mapping[str, float], feed: Feed) -> None:
    low, middle, high = 60.0, 78.0, 110.0
    sheet.text((3, 122.5), "(a) Feedforward friction compensation", align="left")

    # The drive, as the rig meets it.
    sheet.group((79, middle - 9), 85, 33, "Simulated drive")
    controller = sheet.block(Block(42, middle, 32), "PI controller", CONTROL)
    current = sheet.block(
        Block(96, middle, 26), "Current loop", rf"$\pm{number(truth['u_max'], 3)}$ N", "white"
    )
    plant = sheet.block(Block(138, middle, 18), r"$\dfrac{1}{m\,s + b}$")
    friction = sheet.block(Block(138, middle + 15, 18, 9), "Friction")
    error, force, net = (
        sheet.sum((18, middle)), sheet.sum((69, middle)), sheet.sum((119, middle))
    )  # fmt: skip
    velocity = (155.0, middle)

    sheet.arrow((3, middle), (error[0] - RADIUS, middle))
    sheet.arrow((error[0] + RADIUS, middle), controller.left)
    sheet.arrow(controller.right, (force[0] - RADIUS, middle))
    sheet.arrow((force[0] + RADIUS, middle), current.left)
    sheet.arrow(current.right, (net[0] - RADIUS, middle))
    sheet.arrow((net[0] + RADIUS, middle), plant.left)
    sheet.arrow(plant.right, (180, middle))
    sheet.arrow(velocity, (velocity[0], friction.y), friction.right)
    sheet.arrow(friction.left, (net[0], friction.y), (net[0], middle + RADIUS))

    encoder = sheet.block(
        Block(134, low, 32, 11),
        "Encoder",
        _steps(truth),
    )
    estimate = sheet.block(Block(69, low, 36, 11), "Velocity estimate", ESTIMATE)
    tap = (171.0, middle)
    sheet.arrow(tap, (tap[0], low), encoder.right)
    sheet.arrow(encoder.left, estimate.right)
    sheet.arrow(estimate.left, (error[0], low), (error[0], middle - RADIUS))

    # The command side: what is fed forward.
    nominal = sheet.block(Block(30, high, 26), "Nominal loop", "of (b)", PALE)
    compensator = sheet.block(
        Block(78, high, 38), "Friction compensator", r"LuGre (2)–(4), learned", PALE
    )
    branch = (8.0, middle)
    sheet.arrow(branch, (branch[0], high), nominal.left)
    if feed == "nominal":
        sheet.arrow(nominal.right, compensator.left)
        sheet.text((51, high + 2.8), r"$v_r$")
    else:
        above = high + 8.8
        sheet.node((branch[0], high))
        sheet.arrow(
            (branch[0], high), (branch[0], above), (compensator.x, above),
            (compensator.x, compensator.top),
        )  # fmt: skip
        sheet.arrow(nominal.right, (54, high))
        sheet.text((49, high + 2.8), r"$v_r$")
        sheet.text((49, high - 2.8), "to (6)", small=True)
    sheet.arrow((force[0], compensator.bottom), (force[0], middle + RADIUS))

    for at in (branch, velocity, tap):
        sheet.node(at)
    for at, said in (
        ((4, middle + 3.2), r"$v_{cmd}$"),
        ((error[0] - 3.5, middle + 3.0), "+"),
        ((error[0] + 2.4, middle - 4.2), "−"),
        ((force[0] - 3.6, middle + 3.0), "+"),
        ((force[0] + 2.6, middle + 4.2), "+"),
        ((force[0] - 5.0, (middle + high) / 2), r"$F_{ff}$"),
        ((76, middle + 2.6), r"$u$"),
        ((net[0] - 3.6, middle + 3.0), "+"),
        ((net[0] + 2.6, middle + 4.2), "−"),
        ((net[0] - 3.2, friction.y - 5), r"$F_f$"),
        ((178, middle + 2.8), r"$v$"),
        ((106, low + 2.8), r"$x_{enc}$"),
    ):
        sheet.text(at, said)


def _steps(truth: Mapping[str, float]) -> str:
    if not truth["encoder"]:
        return r"$\int v\,\mathrm{d}t$, no steps"
    step = number(1e6 * truth["encoder_step"], 2)
    return rf"$\int v\,\mathrm{{d}}t$ in steps of {step} µm"


def _nominal(sheet: Sheet, loop: VelocityLoop) -> None:
    low, middle = 21.0, 36.0
    sheet.text((3, 48.5), "(b) Nominal velocity loop", align="left")
    controller = sheet.block(Block(37, middle, 32), "PI controller", CONTROL)
    current = sheet.block(Block(71, middle, 20), "Current loop", r"$1/(\tau_i s + 1)$")
    plant = sheet.block(Block(100, middle, 18), r"$\dfrac{1}{m\,s + b}$")
    estimate = sheet.block(Block(60, low, 36, 11), "Velocity estimate", ESTIMATE)
    error = sheet.sum((14, middle))
    tap = (114.0, middle)
    sheet.arrow((3, middle), (error[0] - RADIUS, middle))
    sheet.arrow((error[0] + RADIUS, middle), controller.left)
    sheet.arrow(controller.right, current.left)
    sheet.arrow(current.right, plant.left)
    sheet.arrow(plant.right, (121, middle))
    sheet.arrow(tap, (tap[0], low), estimate.right)
    sheet.arrow(estimate.left, (error[0], low), (error[0], middle - RADIUS))
    sheet.node(tap)
    for at, said in (
        ((4, middle + 3.2), r"$v_{cmd}$"),
        ((error[0] - 3.5, middle + 3.0), "+"),
        ((error[0] + 2.4, middle - 4.2), "−"),
        ((57, middle + 2.8), r"$u$"),
        ((119, middle + 2.8), r"$v_r$"),
    ):
        sheet.text(at, said)
    margins = loop.margins()
    gains = (
        rf"$K_p$ = {number(loop.K_p)} N s/m,  $K_i$ = {number(loop.K_i)} N/m,  "
        rf"$T_s$ = {number(1e3 * loop.T_s)} ms,  $\tau_f$ = {number(1e3 * loop.tau_f)} ms,  "
        rf"$\tau_i$ = {number(1e3 * loop.axis.tau_i)} ms"
    )
    reached = (
        f"crossover {number(margins['crossover_Hz'], 3)} Hz,  "
        f"phase margin {number(margins['phase_margin_deg'], 3)}°,  "
        f"gain margin {number(margins['gain_margin_dB'], 3)} dB,  "
        f"bandwidth (−3 dB) {number(margins['bandwidth_Hz'], 3)} Hz"
    )
    sheet.text((3, 10.0), gains, small=True, align="left")
    sheet.text((3, 5.5), reached, small=True, align="left")


def _step(figure: Figure, loop: VelocityLoop) -> None:
    left, bottom, width, height = 136.0, 12.5, 43.0, 33.0
    axes = figure.add_axes((left / PAGE, bottom / HEIGHT, width / PAGE, height / HEIGHT))
    t, response = loop.step_response(0.025)
    axes.axhspan(0.98, 1.02, color=SHADE, lw=0)
    axes.axhline(1.0, color=FAINT, lw=0.6)
    axes.text(24.5, 0.955, "±2 %", ha="right", va="top", fontsize=SMALL)
    axes.plot(1e3 * t, response.ravel(), color=WITH)
    axes.set(xlim=(0, 25), ylim=(0, None), xlabel="Time [ms]")
    axes.set_ylabel(r"$v_r / v_{cmd}$ [1]")
    name_panel(axes, "c", "Its step response")
