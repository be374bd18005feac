"""Figures over time, velocity and generations: experiments, Figs. 5 and 6, motions, and steps."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FormatStrFormatter, NullLocator

from stickslip import ga
from stickslip.catalog.parameters import HIGH, LOW
from stickslip.evaluation.motions import MOTIONS, REGION, SLOW_MOTIONS, Motion
from stickslip.evaluation.validation import PAPER_TABLE4, Run, Validation
from stickslip.identification.stages import FrictionMap
from stickslip.papers.lugre import tables
from stickslip.papers.lugre.loop_tuning import FRICTION, STAGES, LoopTuning
from stickslip.papers.lugre.published import PAPER_COST, SQUARES, PublishedStudy
from stickslip.papers.lugre.reproduction import Reproduction
from stickslip.papers.lugre.steps import LEARNED, STEPS, UNCOMPENSATED, by_step
from stickslip.presentation import style
from stickslip.presentation.quantity import METRICS, with_error

COMMAND: Any = {"color": style.INK, "lw": 0.8, "ls": style.DASHED}

SHOWN = (-0.02, 0.15)  # What is drawn around an instant [s]


def draw_tracking(validation: Validation) -> Figure:
    """Draw command, velocities and their errors."""
    figure = style.new_figure(style.PAGE, 140.0)
    grid = figure.add_gridspec(3, 2, height_ratios=(1.0, 0.9, 1.1))
    _whole(figure.add_subplot(grid[0, :]), validation)
    below: Axes | None = None
    for column, (letter, region) in enumerate((("b", "start"), ("c", "reverse"))):
        upper = figure.add_subplot(grid[1, column])
        below = figure.add_subplot(grid[2, column], sharex=upper, sharey=below)
        upper.tick_params(labelbottom=False)
        _region(upper, below, validation, validation.instants[region])
        style.name_panel(upper, letter, f"Motion-{region} region, simulated drive")
        below.set_xlabel(f"Time after motion {region}s [ms]")
        if column == 0:
            upper.set_ylabel("Velocity [mm/s]")
            below.set_ylabel(r"Error $v_{cmd} - v$ [mm/s]")
    assert below is not None  # noqa: S101 - there are two columns
    style.legend_below(below)
    return figure


def _whole(axes: Axes, validation: Validation) -> None:
    run = validation.compensated
    style.zero_lines(axes)
    for letter, instant in zip("bc", validation.instants.values(), strict=True):
        axes.axvspan(instant + SHOWN[0], instant + SHOWN[1], color=style.SHADE, lw=0)
        axes.annotate(
            f"({letter})", (instant + sum(SHOWN) / 2, 0.96), xycoords=("data", "axes fraction"),
            ha="center", va="top",
        )  # fmt: skip
    axes.plot(
        run.t, 1e3 * run.v["measured"], color=style.WITH, lw=2.0, alpha=0.55,
        label=r"measured $v$, with compensation",
    )  # fmt: skip
    axes.plot(run.t, 1e3 * run.v_cmd, label=r"command $v_{cmd}$", **COMMAND)
    axes.set(xlabel="Time [s]", ylabel="Velocity [mm/s]", xlim=(run.t[0], run.t[-1]))
    style.name_panel(axes, "a", "Trapezoid, simulated drive")
    axes.legend(loc="lower left")


def _region(velocity: Axes, error: Axes, validation: Validation, instant: float) -> None:
    """Draw both runs around an instant: velocities, and their errors below."""
    t, v_cmd = validation.without.t, validation.without.v_cmd
    begin, end = np.searchsorted(t, [instant + edge - 1e-9 for edge in SHOWN])
    part = slice(int(begin), int(end) + 1)
    t = 1e3 * (t[part] - instant)
    window = 1e3 * REGION[0], 1e3 * REGION[1]
    velocity.axvspan(*window, color=style.SHADE, lw=0)
    error.axvspan(*window, color=style.SHADE, lw=0, label="evaluated")
    style.zero_lines(velocity)
    error.axhline(0.0, color=style.GREY, lw=style.THIN)
    velocity.plot(t, 1e3 * v_cmd[part], **COMMAND)
    for run, colour, label in (
        (validation.without, style.WITHOUT, "without"),
        (validation.compensated, style.WITH, "with"),
    ):
        measured, true = (1e3 * (run.v_cmd - run.v[v])[part] for v in ("measured", "true"))
        velocity.plot(t, 1e3 * run.v["measured"][part], color=colour, lw=style.LINE)
        error.plot(t, measured, color=colour, lw=1.3, label=f"{label} compensation, measured")
        error.plot(t, true, color=colour, lw=style.THIN, label=f"{label}, true")
    velocity.set_xlim(t[0], t[-1])


REVERSALS, CREEP, MOVES = SLOW_MOTIONS
BEFORE = 0.05  # What is drawn before the first of the spans [s]


def draw_motions(reproduction: Reproduction) -> Figure:
    """Draw the command, the motion without compensation and with what was learned."""
    figure = style.new_figure(style.PAGE, 66.0)
    panels = figure.subplots(1, 3)
    shown = (
        ("a", REVERSALS, "0.5 mm/s", "Slow reversals"),
        ("b", CREEP, "0.3 mm/s", "Creep"),
        ("c", MOVES, "20 um", "Small moves"),
    )
    for axes, (letter, motion, region, title) in zip(panels, shown, strict=True):
        runs = reproduction.motions.runs[motion.name]
        _motion(axes, motion, region, runs[UNCOMPENSATED], runs[LEARNED])
        style.name_panel(axes, letter, f"{title}, {region.replace('um', 'µm')}, simulated")
    style.legend_below(panels[0])
    return figure


def _motion(axes: Axes, motion: Motion, region: str, without: Run, compensated: Run) -> None:
    spans = motion.regions[region]
    part = (without.t >= spans[0][0] - BEFORE) & (without.t <= spans[-1][1])
    t = without.t[part] - spans[0][0]
    style.zero_lines(axes)
    quantity, scale, command = "velocity [mm/s]", 1e3, without.v_cmd
    if motion is MOVES:
        quantity, scale, command = "position [µm]", 1e6, without.x_cmd
    for run, colour, label in (
        (without, style.WITHOUT, "without compensation"),
        (compensated, style.WITH, "with the learned compensator"),
    ):
        values = run.x_enc if motion is MOVES else run.v["measured"]
        axes.plot(t, scale * values[part], color=colour, lw=0.7, label=label)
    axes.plot(t, scale * command[part], label="command", **COMMAND)
    axes.set(xlabel="Time [s]", ylabel=f"Encoder’s {quantity}", xlim=(t[0], t[-1]))


LOOKS = {
    ("start", "E_max"): ("o", style.WITHOUT, "white"),
    ("start", "E_rms"): ("o", style.WITHOUT, style.WITHOUT),
    ("reverse", "E_max"): ("s", style.WITH, "white"),
    ("reverse", "E_rms"): ("s", style.WITH, style.WITH),
}
"""Marker, edge and face of each error."""


def draw_steps(reproduction: Reproduction) -> Figure:
    """Draw the errors on the drive's true velocity."""
    figure = style.new_figure(style.PAGE, 78.0)
    axes = figure.subplots()
    table = reproduction.table4()
    true = by_step(table[table["velocity"] == "true"])
    names = [name for name in STEPS if name in true]
    axes.set_yscale("log")
    axes.grid(visible=True, axis="y")
    for shift, (key, (marker, edge, face)) in enumerate(LOOKS.items()):
        row = true[(true["region"] == key[0]) & (true["metric"] == key[1])].iloc[0]
        x = [place + 0.14 * (shift - 1.5) for place in range(len(names))]
        low, high = ([row.get(f"{n}{end}", row[n]) for n in names] for end in (LOW, HIGH))
        axes.vlines(x, low, high, color=edge, lw=0.8)
        axes.plot(
            x, row[names], marker, ls="none", ms=4.5, mec=edge, mfc=face,
            mew=0.9, label=f"{key[0]}, {METRICS[key[1]]}",
        )  # fmt: skip
    for values, colour, which in zip(
        zip(*PAPER_TABLE4.values(), strict=True), (style.GREY, style.INK), ("without", "with"),
        strict=True,
    ):  # fmt: skip
        label = f"real stage (paper), {which}"
        axes.axhspan(min(values), max(values), color=colour, alpha=0.13, lw=0, label=label)
    labels = [STEPS[name] for name in names]
    axes.set_xticks(range(len(names)), labels)
    axes.set_ylabel("Error on the true velocity [mm/s]")
    style.legend_below(axes, 3)
    return figure


POINTS: Any = {"mec": style.WITHOUT, "ecolor": style.WITHOUT, "capsize": 2.0, "elinewidth": 0.8}
CLOUD_POINTS = 400  # Points drawn at most; the low-pass makes neighbours alike


def draw_inertia(reproduction: Reproduction) -> Figure:
    """Draw the force without the fitted friction against acceleration, and the line m a."""
    inertia = reproduction.identification.inertia
    thin = slice(None, None, max(1, len(inertia.acceleration) // CLOUD_POINTS))
    a, force = inertia.acceleration[thin], inertia.force[thin]
    figure = style.new_figure(style.COLUMN, 65.0)
    axes = figure.add_subplot()
    style.zero_lines(axes, vertical=True)
    look: dict[str, Any] = {"ms": 3.0, "mfc": "none", "mec": style.WITHOUT, "mew": 0.7}
    axes.plot(a, force, "o", label="measured, friction removed", **look)
    ends = np.array([a.min(), a.max()])
    slope = with_error(inertia.m.value, inertia.m.standard_error)
    axes.plot(ends, inertia.m.value * ends, color=style.WITH, label=rf"slope $m$ = {slope} kg")
    axes.set(xlabel="Acceleration [m/s$^2$]", ylabel="Motor force less friction [N]")
    axes.legend(loc="upper left")
    return figure


def draw_friction(reproduction: Reproduction) -> Figure:
    """Draw the map in both directions, and friction against speed, logarithmic."""
    friction = reproduction.identification.friction
    figure = style.new_figure(style.COLUMN, 112.0)
    upper, lower = figure.subplots(2, 1)
    _both_directions(upper, friction)
    _against_speed(lower, friction)
    return figure


def _both_directions(axes: Axes, friction: FrictionMap) -> None:
    top = 1.04 * float(np.abs(friction.velocity).max())
    speed = np.geomspace(1e-6, top, 400)
    style.zero_lines(axes, vertical=True)
    for sign in (1.0, -1.0):
        axes.plot(1e3 * sign * speed, friction.curve(sign * speed), color=style.WITH)
    axes.errorbar(
        1e3 * friction.velocity, friction.force, friction.error,
        fmt="o", ms=3.5, mfc="white", **POINTS,
    )  # fmt: skip
    forward, back = friction.breakaway
    axes.plot([0.0, 0.0], [forward, -back], "D", mfc="none", mec=style.INK, zorder=6)
    axes.set(xlabel="Velocity [mm/s]", ylabel="Motor force [N]")
    style.name_panel(axes, "a", "Both directions")


def _against_speed(axes: Axes, friction: FrictionMap) -> None:
    speeds = np.unique(np.abs(friction.velocity))
    edge = 0.6 * float(speeds[0])
    speed = np.geomspace(edge, 1.25 * float(speeds[-1]), 300)
    axes.plot(1e3 * speed, friction.curve(speed), color=style.WITH, label="fitted curve (4), (5)")
    for sign, marker, size, fill, direction in (
        (1, "o", 3.5, style.WITHOUT, "forward"),
        (-1, "s", 6.0, "none", "back"),
    ):
        side = np.sign(friction.velocity) == sign
        axes.errorbar(
            np.abs(1e3 * friction.velocity[side]), np.abs(friction.force[side]),
            friction.error[side], fmt=marker, ms=size, mfc=fill,
            label=f"{direction}, ±1 standard error", **POINTS,
        )  # fmt: skip
    rate = f"{friction.ramp_rate:.2g} N/s"
    axes.plot(
        [1e3 * edge] * 2, friction.breakaway, "D", mfc="none", mec=style.INK, clip_on=False,
        label=f"break-away, ramp of {rate}",
    )  # fmt: skip
    axes.set_xscale("log")
    axes.set_xlim(1e3 * edge, 1.25e3 * float(speeds[-1]))
    ticks = [tick for tick in (0.1, 0.3, 1, 3, 10, 30, 100) if tick >= 1e3 * edge]
    axes.xaxis.set_major_locator(FixedLocator(ticks))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FormatStrFormatter("%g"))
    axes.set(xlabel="Speed [mm/s], logarithmic", ylabel="Friction [N]")
    style.name_panel(axes, "b", "The Stribeck branch")
    axes.legend(loc="upper right")


def draw_presliding(reproduction: Reproduction) -> Figure:
    """Draw force, encoder position against the fitted one, and what is left of it."""
    presliding = reproduction.identification.presliding
    log = presliding.log
    left = 1e6 * (log.x_enc - presliding.x_fit)
    figure = style.new_figure(style.COLUMN, 112.0)
    force, position, rest = figure.subplots(3, 1, sharex=True, height_ratios=(1.0, 1.4, 0.8))
    style.zero_lines(force, position, rest)
    force.plot(log.t, log.F_m, color=style.INK, lw=0.8)
    force.set_ylabel("Motor force [N]")
    style.name_panel(force, "a", "Force steps below break-away")
    position.plot(log.t, 1e6 * log.x_enc, color=style.WITHOUT, lw=2.0, alpha=0.7, label="encoder")
    position.plot(
        log.t, 1e6 * presliding.x_fit, color=style.WITH, lw=style.LINE, label="fitted model"
    )
    position.set_ylabel("Position [µm]")
    position.set_ylim(top=1e6 * (log.x_enc.max() + 0.3 * np.ptp(log.x_enc)))
    position.legend(loc="upper right", ncols=2)
    style.name_panel(position, "b", "Position")
    rest.plot(log.t, left, color=style.WITH, lw=style.THIN)
    rest.set(xlabel="Time [s]", ylabel="Difference [µm]", xlim=(log.t[0], log.t[-1]))
    style.name_panel(rest, "c", "Encoder less model")
    figure.align_ylabels()
    return figure


LEVEL_LOOKS: Any = {
    0.7: {"marker": "v", "mfc": "white"},
    1.0: {"marker": "o", "mfc": style.WITH},
    1.3: {"marker": "^", "mfc": "white"},
}


def draw_stages(loops: LoopTuning) -> Figure:
    """Draw the errors of each step relative to the tuned PI controller, a panel for each motion."""
    figure = style.new_figure(style.PAGE, 74.0)
    panels = figure.subplots(1, len(MOTIONS), sharey=True)
    for axes, letter, motion in zip(panels, "abcd", MOTIONS, strict=True):
        rows = loops.ratios[loops.ratios["motion"] == motion.name]
        for shift, level in zip((-0.22, 0.0, 0.22), FRICTION, strict=True):
            own = rows[rows["friction"] == level].groupby("stage", sort=False)["ratio"]
            middle, low, high = own.median(), own.min(), own.max()
            axes.errorbar(
                np.arange(len(middle)) + shift, middle, (middle - low, high - middle),
                ls="none", ms=4.0, mec=style.WITH, ecolor=style.WITH, elinewidth=0.8,
                label=f"friction × {level:g}", **LEVEL_LOOKS[level],
            )  # fmt: skip
        axes.axhline(1.0, color=style.GREY, lw=style.THIN)
        axes.set_yscale("log")
        axes.yaxis.set_major_locator(FixedLocator([0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0]))
        axes.yaxis.set_minor_locator(NullLocator())
        axes.yaxis.set_major_formatter(FormatStrFormatter("%g"))
        axes.grid(visible=True, axis="y")
        labels = [tables.STAGES[stage] for stage in STAGES]
        axes.set_xticks(range(len(labels)), labels, rotation=40, ha="right", rotation_mode="anchor")
        style.name_panel(axes, letter, motion.name.capitalize())
    panels[0].set_ylabel("Error relative to tuned PI [1]")
    style.legend_below(panels[0], 3)
    return figure


def draw_fitness(loops: LoopTuning) -> Figure:
    """Draw the best cost over the evaluations, a band over seeds."""
    figure = style.new_figure(style.COLUMN, 70.0)
    axes: Axes = figure.add_subplot()
    costs = [one.algorithm.history["cost"].to_numpy(dtype=float) for one in loops.learned]
    most = max(map(len, costs))
    at = np.arange(1, most + 1)
    best = [
        np.pad(np.minimum.accumulate(cost), (0, most - len(cost)), mode="edge") for cost in costs
    ]
    low, middle, high = (f(best, axis=0) for f in (np.min, np.median, np.max))
    axes.fill_between(at, low, high, color=style.WITH, alpha=0.18, lw=0, label="range over seeds")
    axes.plot(at, middle, color=style.WITH, lw=style.THICK, label="median")
    axes.grid(visible=True, axis="y")
    axes.set(xlabel="Evaluations [1]", ylabel="Cost [1]", xlim=(1, most))
    axes.set_ylim(0.0, 1.1 * float(high[np.isfinite(high)].max()))
    style.legend_below(axes)
    return figure


BAND = "#9dbbd6"


def draw_band(study: PublishedStudy) -> Figure:
    """Draw Fig. 5 of a study."""
    table = study.fitness()
    best = table.pivot_table(index="generation", columns="seed", values="best_cost")
    generation = best.index.to_numpy(dtype=float)
    low, first, middle, third, high = np.quantile(best.to_numpy(), (0, 0.25, 0.5, 0.75, 1), axis=1)
    figure = style.new_figure(style.COLUMN, 82.0)
    axes = figure.add_subplot()
    axes.grid(visible=True, axis="y")
    axes.set(yscale="log", xlabel="Generation [1]", xlim=(generation[0], generation[-1]))
    axes.set_ylabel(r"Cost $\sum (v - v_r)^2$ [m$^2$/s$^2$]")
    for bottom, top, colour, label in (
        (low, high, style.PALE, f"{best.shape[1]} seeds, all"),
        (first, third, BAND, "middle half of them"),
    ):
        axes.fill_between(generation, bottom, top, step="post", color=colour, lw=0, label=label)
    axes.step(generation, middle, where="post", color=style.WITH, lw=style.THICK, label="median")
    costs, runs = study.costs(SQUARES), np.median([one.runs for one in study.seeds[SQUARES]])
    middle_cost, at = float(np.median(costs)), float(runs) / ga.PAPER.population
    axes.errorbar(
        [at], [middle_cost], [[middle_cost - costs.min()], [costs.max() - middle_cost]],
        fmt="D", ms=4.0, mfc="white", mec=style.INK, ecolor=style.INK, capsize=2.0,
        label=f"least squares, {runs:.0f} runs",
    )  # fmt: skip
    axes.axhline(
        PAPER_COST, color=style.INK, lw=0.8, ls=style.DASHED, label="real stage (paper), end"
    )
    axes.axhline(
        study.cost_without, color=style.WITHOUT, lw=0.8, ls=(0, (1, 1.5)),
        label="no compensation",
    )  # fmt: skip
    style.legend_below(axes, 2)
    return figure
