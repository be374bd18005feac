"""Candidates of a tuned loop in lanes, against runs of the FMUs one by one, CPU time, by law."""

from pathlib import Path
from time import process_time
from unittest.mock import patch

import numpy as np

from stickslip.catalog.parameters import PAPER, friction_law, scaled_start
from stickslip.cosim import Trapezoid
from stickslip.loops.drive_loop import DriveLoop
from stickslip.loops.family_cost import FamilyCost
from stickslip.servo import lanes
from stickslip.servo.axis import Axis, Datasheet
from stickslip.servo.observer import MASSES, design_observer
from stickslip.servo.systems import Compensator
from stickslip.servo.velocity_loop import close_velocity_loop
from stickslip.trial.benefit import bench_of
from stickslip.trial.family import Evidence, family

LAWS = ("lugre", "gms", "elasto_plastic", "dahl", "coulomb_stribeck", "armstrong")
CANDIDATES, REPEATS = 10, 3  # as many as a generation has
COMMAND, SHEET = Trapezoid(0.02, 0.4, 0.1, 0.05), Datasheet(peak_force=200.0)
LOOP = close_velocity_loop(Axis(PAPER["m"], PAPER["b"], 1e-4), 5e-4, 1e-3, 1000.0, K_i=4e4)


def measure(_: Path) -> dict[str, float]:
    """Return CPU time per candidate and ratios; both ways take turns, and the least time counts."""
    found = {}
    for name in LAWS:
        law = friction_law(name)
        deflection = PAPER["F_c"] / PAPER["sigma_0"]
        friction = {
            one: PAPER.get(one, scaled_start(of, PAPER["F_c"], deflection))
            for one, of in law.parameters.items()
            if len(of.start) == 1
        }
        observer = design_observer(LOOP, SHEET.encoder_step, friction["F_c"]).observer
        start = DriveLoop(
            LOOP,
            law,
            Compensator("compensator", "compensator", law.share(friction, 0.8)),
            Compensator("observer", "dob", observer.parameters()),
            share=0.8,
        )
        problem = start.problem({})
        drives = family(law, friction, COMMAND, Evidence())
        tried = np.array([problem.start * 0.99**k for k in range(CANDIDATES)])
        with (
            bench_of(law, LOOP, friction, drives, command=COMMAND, datasheet=SHEET) as bench,
            FamilyCost(bench, start, MASSES, problem.names) as cost,
        ):
            ways = {"in lanes": lanes.FEWEST, "by FMUs": lanes.LANES + 1}
            times: dict[str, list[float]] = {way: [] for way in ways}
            costs = {}
            for _ in range(REPEATS):
                for way, fewest in ways.items():
                    with patch.object(lanes, "FEWEST", fewest):
                        begin = process_time()
                        costs[way] = [call() for call in cost.together(tried)]
                        times[way].append((process_time() - begin) / len(tried))
            least = {way: min(seconds) for way, seconds in times.items()}
            if costs["in lanes"] != costs["by FMUs"]:
                raise SystemExit(f"{name}: lanes and FMUs differ: {costs}")
            found |= {f"{name}: ms per candidate {way}": 1e3 * s for way, s in least.items()}
            found[f"{name}: by FMUs / in lanes"] = least["by FMUs"] / least["in lanes"]
    return found
