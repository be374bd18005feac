"""Figs. 2 to 4: the loops, the learning scheme, and its flow chart."""

from collections.abc import Mapping
from itertools import pairwise

from matplotlib.figure import Figure

from stickslip import ga
from stickslip.catalog.parameters import friction_law
from stickslip.papers.lugre.reproduction import Reproduction
from stickslip.presentation.diagram import Block, Sheet
from stickslip.presentation.quantity import number
from stickslip.presentation.style import (
    FAINT,
    PAGE,
    PALE,
    SHADE,
    SMALL,
    WITH,
    name_panel,
    new_figure,
)
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.tuning.loop_learning import LEVELS
from stickslip.tuning.loop_runs import GENES, training_motion

LOOPS_HEIGHT = 127.0
CONTROL = r"$K_p + K_i T_s \, z/(z-1)$"
PLANT = r"$\dfrac{1}{m\,s + b}$"
ESTIMATE = r"difference, low-pass $\tau_f$"


def draw_loops(loop: VelocityLoop, truth: Mapping[str, float], law: str) -> Figure:
    """Draw a loop around a drive whose parameters are ``truth``, with the law of a compensator."""
    figure = new_figure(PAGE, LOOPS_HEIGHT, free=True)
    sheet = Sheet(figure)
    _compensated(sheet, truth, law)
    _nominal_loop(sheet)
    _step_response(figure, loop)
    return figure


def _compensated(sheet: Sheet, truth: Mapping[str, float], law: str) -> None:
    low, middle, high = 60.0, 78.0, 110.0
    sheet.text((3, 122.5), "(a) Feedforward friction compensation", align="left")
    sheet.group((79, middle - 9), 85, 33, "Simulated drive")
    controller = sheet.block(Block(42, middle, 32), "PI controller", CONTROL)
    limit = rf"$\pm{number(truth['u_max'], 3)}$ N"
    current = sheet.block(Block(96, middle, 26), "Current loop", limit)
    plant = sheet.block(Block(138, middle, 18), PLANT)
    friction = sheet.block(Block(138, middle + 15, 18, 9), "Friction")
    error = sheet.sum((18, middle), left="+", below="−")
    force = sheet.sum((69, middle), left="+", above="+")
    net = sheet.sum((119, middle), left="+", above="−")
    velocity, tap = (155.0, middle), (171.0, middle)
    sheet.chain((3, middle), error, controller, force, current, net, plant, (180, middle))
    sheet.arrow(velocity, (velocity[0], friction.y), friction.right)
    sheet.arrow(friction.left, (net.x, friction.y), net.top)

    integral = r"$\int v\,\mathrm{d}t$"
    steps = ", no steps"
    if truth["encoder"]:
        steps = f" in steps of {number(1e6 * truth['encoder_step'], 2)} µm"
    encoder = sheet.block(Block(134, low, 32, 11), "Encoder", integral + steps)
    estimate = sheet.block(Block(69, low, 36, 11), "Velocity estimate", ESTIMATE)
    sheet.arrow(tap, (tap[0], low), encoder.right)
    sheet.arrow(encoder.left, estimate.right)
    sheet.arrow(estimate.left, (error.x, low), error.bottom)

    # The command side: nominal loop and feedforward.
    nominal = sheet.block(Block(30, high, 26), "Nominal loop", "of (b)", PALE)
    model = f"{_model(law)}, learned"
    compensator = sheet.block(Block(78, high, 38), "Friction compensator", model, PALE)
    branch = (8.0, middle)
    sheet.arrow(branch, (branch[0], high), nominal.left)
    sheet.arrow(nominal.right, compensator.left)
    sheet.text((51, high + 2.8), r"$v_r$")
    sheet.arrow((force.x, compensator.bottom[1]), force.top)

    for at in (branch, velocity, tap):
        sheet.node(at)
    for at, label in (
        ((4, middle + 3.2), r"$v_{cmd}$"),
        ((force.x - 5.0, (middle + high) / 2), r"$F_{ff}$"),
        ((76, middle + 2.6), r"$u$"),
        ((net.x - 3.2, friction.y - 5), r"$F_f$"),
        ((178, middle + 2.8), r"$v$"),
        ((106, low + 2.8), r"$x_{enc}$"),
    ):
        sheet.text(at, label)


def _model(law: str) -> str:
    """Return the friction law of the compensator, with the paper's equations of LuGre."""
    return friction_law(law).title + (" (2)–(4)" if law == "lugre" else "")


def _nominal_loop(sheet: Sheet) -> None:
    low, middle = 21.0, 36.0
    sheet.text((3, 48.5), "(b) Nominal velocity loop", align="left")
    controller = sheet.block(Block(37, middle, 32), "PI controller", CONTROL)
    current = sheet.block(Block(71, middle, 20), "Current loop", r"$1/(\tau_i s + 1)$")
    plant = sheet.block(Block(100, middle, 18), PLANT)
    estimate = sheet.block(Block(60, low, 36, 11), "Velocity estimate", ESTIMATE)
    error = sheet.sum((14, middle), left="+", below="−")
    tap = (114.0, middle)
    sheet.chain((3, middle), error, controller, current, plant, (121, middle))
    sheet.arrow(tap, (tap[0], low), estimate.right)
    sheet.arrow(estimate.left, (error.x, low), error.bottom)
    sheet.node(tap)
    for at, label in (
        ((4, middle + 3.2), r"$v_{cmd}$"),
        ((57, middle + 2.8), r"$u$"),
        ((119, middle + 2.8), r"$v_r$"),
    ):
        sheet.text(at, label)


def _step_response(figure: Figure, loop: VelocityLoop) -> None:
    left, bottom, width, height = 136.0, 12.5, 43.0, 33.0
    across, up = PAGE, LOOPS_HEIGHT
    axes = figure.add_axes((left / across, bottom / up, width / across, height / up))
    t, response = loop.step_response(0.025)
    axes.axhspan(0.98, 1.02, color=SHADE, lw=0)
    axes.axhline(1.0, color=FAINT, lw=0.6)
    axes.text(24.5, 0.955, "±2 %", ha="right", va="top", fontsize=SMALL)
    axes.plot(1e3 * t, response.ravel(), color=WITH)
    axes.set(xlim=(0, 25), ylim=(0, None), xlabel="Time [ms]")
    axes.set_ylabel(r"$v_r / v_{cmd}$ [1]")
    name_panel(axes, "c", "Its step response")


def draw_scheme(reproduction: Reproduction) -> Figure:
    """Draw the scheme with the algorithm of this run, and what its compensator is driven by."""
    figure = new_figure(PAGE, 84.0, free=True)
    sheet = Sheet(figure)
    low, middle, high, top = 15.0, 40.0, 66.0, 79.0
    sheet.group((37, 2), 52, 50, "")
    sheet.text((63, 5.2), "Velocity loop with compensators", small=True)
    nominal = sheet.block(Block(36, high, 42), "Nominal velocity loop", "without friction", PALE)
    model = f"{_model(reproduction.options.law)}, observer"
    compensator = sheet.block(Block(63, middle, 40), "Friction compensators", model, PALE)
    levels = " and ".join(f"{level:g}" for level in LEVELS)
    drive = sheet.block(Block(63, low, 44), "Velocity loop", f"drive; models, friction × {levels}")
    algorithm = reproduction.loops.best.algorithm
    title = algorithm.title.removeprefix("a ").partition(" of ")[0]
    learner = sheet.block(
        Block(120, middle, 30, 14), title[0].upper() + title[1:], "Steps 1 to 4", PALE
    )
    cost = sheet.block(Block(156, middle, 27, 14), "Cost", "errors, of those of\nthe tuned PI")
    gap = sheet.sum((177, middle))

    branch = (9.0, high)
    sheet.arrow((3, high), nominal.left)
    sheet.arrow(branch, (branch[0], low), drive.left)
    sheet.arrow(branch, (branch[0], top), (gap.x, top), gap.top)
    sheet.arrow(drive.right, (gap.x, low), gap.bottom)
    sheet.arrow(nominal.right, (compensator.x, high), compensator.top)
    sheet.arrow(compensator.bottom, drive.top)
    sheet.arrow(gap.left, cost.right)
    sheet.arrow(cost.left, learner.right)
    sheet.arrow(learner.left, compensator.right)
    sheet.arrow(learner.bottom, (learner.x, low + 3.0), (drive.right[0], low + 3.0))

    sheet.node(branch)
    for at, label in (
        ((4.5, high + 3.0), r"$v_{cmd}$"),
        ((66.5, high + 3.0), r"$v_r$"),
        ((150, low + 3.0), r"$v$"),
        ((compensator.x + 4.5, (compensator.bottom[1] + drive.top[1]) / 2), r"$F_{ff}$"),
        ((gap.x - 3.6, middle + 4.4), "+"),
        ((gap.x - 3.6, middle - 4.4), "−"),
        ((94, middle + 3.2), "shares,"),
        ((94, middle - 3.4), "rate"),
        ((103, low + 6.2), r"$K_p$, $K_i$, $\tau_f$, $m_{ff}$"),
    ):
        sheet.text(at, label)
    return figure


def draw_flow(reproduction: Reproduction) -> Figure:
    """Draw the flow chart."""
    algorithm = reproduction.loops.best.algorithm
    figure = new_figure(PAGE, 112.0, free=True)
    sheet = Sheet(figure)
    first = sheet.block(Block(46, 101, 76, 16), "Step 1. Initialization", _initial(algorithm))
    fitness = sheet.block(
        Block(46, 77, 76, 16),
        "Step 2. Fitness calculation",
        f"each candidate runs for {number(training_motion().duration, 2)} s on drive and models:\n"
        "errors and change of force, of those of the tuned PI",
    )
    ended = sheet.decision(Block(46, 46, 80, 30), "Step 3. Evaluation", _end(algorithm.limits))
    learned = sheet.block(Block(46, 14, 76, 16), "Learned loop", _learned(algorithm), PALE)
    operations = _operations(algorithm)
    heights = [fitness.y - 17.5 * k for k in reversed(range(len(operations)))]
    lowest = heights[0] - 11.0
    sheet.group((100, lowest), 80, 93 - lowest, "Step 4. New generation")
    blocks = [
        sheet.block(Block(140, y, 70, 14.5), *operation)
        for y, operation in zip(heights, operations, strict=True)
    ]

    for upper, lower in pairwise((first, fitness, ended, learned)):
        sheet.arrow(upper.bottom, lower.top)
    for lower, upper in pairwise(blocks):
        sheet.arrow(lower.top, upper.bottom)
    bend = 94.0
    sheet.arrow(ended.right, (bend, ended.y), (bend, blocks[0].y), blocks[0].left)
    sheet.arrow(blocks[-1].left, fitness.right)
    sheet.text((90, ended.y + 2.6), "no", small=True)
    sheet.text((50.5, (ended.bottom[1] + learned.top[1]) / 2), "yes", small=True)
    return figure


def _initial(algorithm: ga.Optimiser) -> str:
    size = algorithm.history["generation"].eq(algorithm.history["generation"].iloc[0]).sum()
    return (
        f"{size} candidates, the tuned PI with the identified friction\n"
        f"among them; {len(GENES)} genes"
    )


def _end(limits: ga.Limits) -> str:
    """Return the question of Step 3."""
    counts = {"generations": limits.generations, "evaluations": limits.evaluations}
    parts = [f"{count} {name} done" for name, count in counts.items() if count is not None]
    if limits.target is None:
        parts.append("cost at most ε (not set)?")
    else:
        parts.append(f"cost at most ε = {number(limits.target)} ?")
    return ",\nor ".join(parts)


def _learned(algorithm: ga.Optimiser) -> str:
    return (
        f"the best of {number(algorithm.evaluations, 6)} candidates in "
        f"{number(algorithm.generation, 6)} generations,\nrun again"
    )


def _operations(algorithm: ga.Optimiser) -> list[tuple[str, str]]:
    """Return what makes a new generation, in its order."""
    if not isinstance(algorithm, ga.GeneticAlgorithm):
        title = algorithm.title[0].upper() + algorithm.title[1:]
        return [
            ("Evaluated candidates", "all so far, with their costs"),
            (title, f"{algorithm.batch} new candidates"),
        ]
    settings = algorithm.settings
    children = settings.population - settings.elites
    return [
        ("Selection", f"elite of {settings.elites}"),
        ("Crossover", settings.crossover),
        ("Mutation", settings.mutation),
        ("Next generation", f"the elite and {children} new candidates"),
    ]
