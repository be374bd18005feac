"""Whether the controller that is said to have made a log commands the force that was logged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import cosim
from stickslip.estimation.known_loop import NO_LIMIT
from stickslip.estimation.motion import position_of
from stickslip.measurement import Array, smoothed
from stickslip.recording import Recording

SHARE = 1.0 / 50.0
"""Cut-off of the low-pass, as a share of the sample rate: noise of the force is no disagreement."""
SHIFTS = range(5)  # samples by which the logged force may be older than the command


@dataclass(frozen=True)
class ControllerCheck:
    """What the controller FMU commands along the recorded motion.

    Attributes
    ----------
    force : (n,) that it commands, each value held from its sample on [N]
    error : root mean square of logged without commanded force, relative to the logged one, both
        low-passed; NaN where no force was logged
    shift : samples by which the log shows a command late
    """

    force: Array
    error: float
    shift: int


def check_controller(
    fmus: Path, recording: Recording, gains: Mapping[str, float]
) -> ControllerCheck:
    """Run the controller FMU along the recorded motion and commands."""
    system = cosim.System("controller")
    limits = {"u_max": NO_LIMIT, "T_s": recording.T_s}
    system.add("controller", fmus / "velocity_controller.fmu", {**limits, **gains})
    signals = {
        "x_enc": position_of(recording),
        "v_cmd": recording.velocity_command,
        "x_cmd": recording.position_command,
    }
    inputs = {name: signal for name, signal in signals.items() if signal is not None}
    for name in inputs:
        system.expose(name, f"controller.{name}")
    stop = (len(recording.t) - 1) * recording.T_s
    with system.prepare(step=recording.T_s, stop=stop, record=["controller.u"]) as simulation:
        shown = simulation.run(inputs=inputs)["controller.u"]
    commanded = np.append(shown[1:], shown[-1])  # row n + 1 shows what sample n decided
    if recording.force is None:
        return ControllerCheck(commanded, float("nan"), 0)
    n = len(commanded) - max(SHIFTS)

    def slow(force: Array) -> Array:
        return smoothed(force, recording.T_s, SHARE / recording.T_s)

    size = float(np.linalg.norm(slow(recording.force))) or 1.0
    errors = [
        float(np.linalg.norm(slow(recording.force[shift : shift + n] - commanded[:n]))) / size
        for shift in SHIFTS
    ]
    best = int(np.argmin(errors))
    return ControllerCheck(commanded, errors[best], best)
