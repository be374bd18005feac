"""What was recorded: command and position, velocity, force."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.identification.criteria.motion import measured_force, position_of
from stickslip.identification.estimation import Estimation
from stickslip.report.learned.parts import measures_friction
from stickslip.report.learned.scales import (
    WORDS,
    Scale,
    force_scale,
    from_start,
    position_scale,
    velocity_scale,
)
from stickslip.report.learned.thinning import thinned
from stickslip.report.style import (
    FAINT,
    INK,
    PAGE,
    THIN,
    WITH,
    WITHOUT,
    name_panel,
    new_figure,
)
from stickslip.servo.measurement import Array

DASHED = (0, (4, 2))


def draw(estimation: Estimation) -> Figure:
    """Draw the signals over time, commands dashed."""
    recording, t = estimation.recording, estimation.recording.t
    recorded, velocity = position_of(recording), estimation.figures.velocity_recorded
    position = from_start(recorded)
    command = recording.position_command
    if command is not None:
        command = command - (recorded[0] - position[0])
    place, push = WORDS[recording.motion]
    figure = new_figure(PAGE, 115.0)
    panels = figure.subplots(3, 1, sharex=True)
    where = place.capitalize()
    if recording.position is None:
        where += ", integrated from the velocity"
    elif position is not recorded:
        where += ", from its first value on"
    _panel(
        panels[0], "a", where, t, position, command,
        position_scale(recording.motion, position),
    )  # fmt: skip
    _panel(
        panels[1], "b", "Velocity, low-passed", t, velocity, recording.velocity_command,
        velocity_scale(recording.motion, velocity),
    )  # fmt: skip
    force = measured_force(recording)
    said = "Measured friction" if measures_friction(estimation) else f"Motor {push}"
    _panel(panels[2], "c", said, t, force, None, force_scale(recording.motion, force), INK)
    panels[2].set(xlabel="Time [s]", xlim=(t[0], t[-1]))
    figure.align_ylabels()
    return figure


def _panel(
    axes: Axes,
    letter: str,
    said: str,
    t: Array,
    signal: Array,
    command: Array | None,
    scale: Scale,
    colour: str = WITH,
) -> None:
    axes.axhline(0.0, color=FAINT, lw=THIN)
    axes.plot(*thinned(t, scale.factor * signal), color=colour, lw=0.8, label="recorded")
    if command is not None:
        axes.plot(
            *thinned(t, scale.factor * command), color=WITHOUT, lw=0.8, ls=DASHED, label="command"
        )
        low, high = axes.get_ylim()
        axes.set_ylim(low, high + 0.28 * (high - low))
        axes.legend(loc="upper right", ncols=2)
    axes.set_ylabel(f"{said.split(',')[0].split()[-1].capitalize()} [{scale.unit}]")
    name_panel(axes, letter, said)
