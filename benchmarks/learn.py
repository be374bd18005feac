"""``learn`` of a 20 s log with its controller known, in runs of the loop that it fits.

Such a run is what no estimation by output error can do without, so the ratio says how many of them
a stage is worth. Two workers are compared with one.
"""

import time
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd

import stickslip as ss
from stickslip.identification.estimation import Search
from stickslip.logs import Column, Description
from stickslip.output import Progress
from stickslip.planning import plan
from stickslip.rigs.contract import commissioning_loop
from stickslip.servo.axis import Datasheet
from stickslip.servo.systems import build_fmus, servo_loop
from stickslip.studies.learn.recorded import gains_of

RUNS = 20


class Stages(Progress):
    """When each stage began."""

    def __init__(self) -> None:
        self.begun: list[tuple[str, float]] = []

    def stage(self, name: str) -> None:
        self.begun.append((name, time.perf_counter()))


def write_log(folder: Path) -> tuple[Path, Description, float]:
    """Write the log of a run; return it, what its columns are, and the seconds of a run."""
    build_fmus(folder, {})
    loop = commissioning_loop(Datasheet())
    v_cmd = plan()["velocity_command"].to_numpy()
    t = np.arange(len(v_cmd)) * loop.T_s
    record = ("drive.x_enc", "drive.F_m")
    with servo_loop(folder, loop).prepare(step=loop.T_s, stop=t[-1], record=record) as simulation:
        inputs = {"v_cmd": v_cmd}
        result = simulation.run({"drive.noise": True, "drive.seed": 1}, inputs)
        simulation.run({}, inputs)  # is done twice
        begin = time.perf_counter()
        for _ in range(RUNS):
            simulation.run({}, inputs)
        one = (time.perf_counter() - begin) / RUNS
    log = pd.DataFrame(
        {"time": t, "position": result[record[0]], "force": result[record[1]]}
    ).assign(velocity_command=v_cmd)
    log.to_csv(path := folder / "log.csv", index=False)
    columns = {name: Column(name) for name in log}
    return path, Description(columns=columns, controller="PI", gains=gains_of(loop)), one


def measure(folder: Path) -> dict[str, float]:
    path, description, one = write_log(folder)
    figures: dict[str, float] = {}
    for workers in (1, 2):
        stages = Stages()
        search = Search(workers=workers)
        ss.learn(path, description, search=search, progress=stages)
        stages.stage("")
        for (name, begin), (_, end) in pairwise(stages.begun):
            figures[f"{name}, workers = {workers}"] = (end - begin) / one
        figures[f"all, workers = {workers}"] = (stages.begun[-1][1] - stages.begun[0][1]) / one
    return figures
