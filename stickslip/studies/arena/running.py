"""What an entrant costs where it runs: memory, code, and time per sample."""

from __future__ import annotations

import time
import zipfile
from pathlib import Path

from stickslip import cosim
from stickslip.compensators.entrants import Entrant, TunedEntrant
from stickslip.servo.chain_response import sliding
from stickslip.servo.systems import lone_chain
from stickslip.servo.velocity_loop import VelocityLoop

STEPS, REPEATS = 4000, 3


def footprint(fmus: Path, one: Entrant) -> dict[str, float]:
    """Return numbers that it keeps between samples, and bytes of its binaries for this platform.

    The numbers are missing for an FMU of the user, which does not tell them.
    """
    parts = [part for part in one.parts if part.compensator is not None]
    found = {"binary size": 0.0}
    for part in parts:
        with zipfile.ZipFile(fmus / f"{part.file}.fmu") as archive:
            members = archive.infolist()
        # The FMUs of the arena are built for the platform that runs them.
        binaries = [one.file_size for one in members if one.filename.startswith("binaries/")]
        found["binary size"] += max(binaries, default=0)
    if not any(part.own_fmu for part in parts):
        found["states"] = float(sum(len(part.kept) for part in parts))
    return found


def seconds_per_step(
    fmus: Path, loop: VelocityLoop, one: Entrant, tuned: TunedEntrant, friction: float
) -> dict[str, float]:
    """Return the processor time of a sample of its FMUs [s], in motion against a friction [N].

    Nothing where it has none, or where one fails.
    """
    if not one.chain:
        return {}
    system, force = lone_chain(fmus, loop, one.chain)
    taken = []
    record = cosim.Record((force,), keep="last")
    moving = sliding(loop, friction, STEPS + 1)
    inputs = {role: moving[role] for role in system.inputs}
    with system.prepare(step=loop.T_s, stop=STEPS * loop.T_s, record=record) as simulation:
        for _ in range(REPEATS):
            begun = time.thread_time()
            try:
                simulation.run(tuned.parameters, inputs)
            except cosim.SimulationError:
                return {}
            taken.append(time.thread_time() - begun)
    return {"step": min(taken) / STEPS}
