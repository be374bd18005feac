"""How often the 95 % intervals of learned parameters hold the truth.

    python -m tests.interval_coverage --recordings 100 --drives varied --out coverage

Each recording is simulated with noise and a seed of its own, of Table 2's drive or of another one
each time, and learned like a log; coverage.csv and coverage.png are rewritten after each.
"""

from __future__ import annotations

import argparse
import io
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, NullLocator

from stickslip.catalog.parameters import PAPER, UNITS
from stickslip.identification.estimation import Task, candidate_fmus, learn
from stickslip.logs import Recording
from stickslip.pipeline.record_mode import COMMISSIONING, gains_of
from stickslip.planning import plan
from stickslip.report.quantity import meaning, number
from stickslip.report.style import (
    GREY,
    PAGE,
    RESOLUTION,
    THIN,
    WITH,
    WITHOUT,
    house_style,
    new_figure,
)
from stickslip.servo.datasheet import Datasheet
from stickslip.servo.systems import servo_loop
from stickslip.servo.velocity_loop import VelocityLoop, design_velocity_loop

MASS = (3.0, 12.0)  # [kg]
F_C = (2.0, 12.0)  # [N]
RISE = (1.1, 2.0)  # F_s / F_c
SIGMA_0 = (1e5, 1e6)  # [N/m], evenly in its logarithm
EVEN = 3.0
"""Median half-widths up to which the axis of the picture is linear; beyond, logarithmic."""
DAMPING = (0.3, 2.0)  # sigma_1 / (2 sqrt(sigma_0 m))


def main() -> None:
    """Simulate, learn, count."""
    parser = argparse.ArgumentParser(prog="python -m tests.interval_coverage", description=__doc__)
    parser.add_argument("--recordings", type=int, default=100, metavar="N")
    parser.add_argument("--drives", choices=("varied", "same"), default="varied")
    parser.add_argument("--first", type=int, default=0, help="seed of the first recording")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    parser.add_argument("--out", type=Path, default=Path("coverage"), metavar="DIR")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    seeds = range(options.first, options.first + options.recordings)
    learned = partial(learn_one, options.drives)
    tables: list[pd.DataFrame] = []
    with ProcessPoolExecutor(options.workers, mp_context=get_context("spawn")) as pool:
        for table in pool.map(learned, seeds):
            tables.append(table)
            everything = pd.concat(tables)
            everything.to_csv(options.out / "coverage.csv", index=False, lineterminator="\n")
            (options.out / "coverage.png").write_bytes(draw(everything))
            row = table.iloc[0]
            missed = ", ".join(table.parameter[~table.holds]) or "none"
            print(
                f"{row.seed:5} {row.seconds:6.1f} s  {row.criterion:13} missed: {missed}",
                flush=True,
            )
    print("\nshare of 95 % intervals that hold the truth, and relative half-width")
    for name, rows in everything.groupby("parameter", sort=False):
        width = float(np.median(0.5 * (rows.high - rows.low) / rows.truth))
        print(f"{name:8} {rows.holds.mean():7.1%} of {len(rows)}   {width:8.3%}")


def drive(drives: str, seed: int) -> dict[str, float]:
    """Return a drive's parameters by name."""
    truth = dict(PAPER)
    if drives == "varied":
        rng = np.random.default_rng(seed)
        truth["m"] = rng.uniform(*MASS)
        truth["F_c"] = rng.uniform(*F_C)
        truth["F_s"] = truth["F_c"] * rng.uniform(*RISE)
        truth["sigma_0"] = float(np.exp(rng.uniform(*np.log(SIGMA_0))))
        critical = 2.0 * np.sqrt(truth["sigma_0"] * truth["m"])
        truth["sigma_1"] = critical * rng.uniform(*DAMPING)
    return truth


def record(fmus: Path, loop: VelocityLoop, truth: dict[str, float], seed: int) -> Recording:
    """Simulate the planned experiment on a noisy drive."""
    v_cmd = plan()["velocity_command"].to_numpy()
    measured = ("drive.x_enc", "drive.F_m")
    stop = (len(v_cmd) - 1) * loop.T_s
    parameters = {f"drive.{name}": value for name, value in truth.items()}
    noise = {"drive.noise": True, "drive.seed": seed + 1}
    with servo_loop(fmus, loop).prepare(step=loop.T_s, stop=stop, record=measured) as simulation:
        result = simulation.run({**parameters, **noise}, {"v_cmd": v_cmd})
    step = Datasheet().encoder_step
    x, force = (result[name] for name in measured)
    return Recording(result.time, x, force, velocity_command=v_cmd, encoder_step=step)


def learn_one(drives: str, seed: int) -> pd.DataFrame:
    """Return a row for each parameter of one recording."""
    truth, sheet = drive(drives, seed), Datasheet()
    loop = design_velocity_loop(sheet.axis(sheet.mass, 0.0), COMMISSIONING)
    with candidate_fmus() as fmus:
        recording = record(fmus, loop, truth, seed)
        begin = time.perf_counter()
        estimation = learn(Task(fmus, recording, gains_of(loop), seed=seed))
    seconds = time.perf_counter() - begin
    return pd.DataFrame(_rows(truth, estimation.known)).assign(
        seed=seed,
        criterion=estimation.criterion,
        reason=estimation.reason,
        seconds=round(seconds, 1),
    )


def _rows(truth, known) -> Iterator[dict[str, object]]:
    for name, found in known.items():
        yield {
            "parameter": name,
            "unit": UNITS[name],
            "truth": truth[name],
            "value": found.value,
            "standard_error": found.standard_error,
            "low": found.low,
            "high": found.high,
            "identifiability": found.identifiability,
            "holds": found.low <= truth[name] <= found.high,
        }


def draw(table: pd.DataFrame) -> bytes:
    """Return a PNG file: a panel for each parameter, a line for each recording."""
    names = list(dict.fromkeys(table["parameter"]))
    with house_style():
        figure = new_figure(PAGE, 32.0 * len(names))
        panels = figure.subplots(len(names), 1, sharex=True, squeeze=False).ravel()
        for axes, name in zip(panels, names, strict=True):
            _panel(axes, table[table["parameter"] == name], name)
        panels[-1].set_xlabel("Recording")
        figure.align_ylabels()
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=RESOLUTION, metadata={"Software": None})
    return stream.getvalue()


def _panel(axes: Axes, rows: pd.DataFrame, name: str) -> None:
    truth = rows["truth"].to_numpy()
    low, value, high = (
        100.0 * (rows[column].to_numpy() / truth - 1.0) for column in ("low", "value", "high")
    )
    k, holds = np.arange(1, len(rows) + 1), rows["holds"].to_numpy(dtype=bool)
    even = EVEN * float(np.median(0.5 * (high - low)))
    limit = max(even, 1.2 * float(np.max(np.abs([low, high]))))
    axes.axhline(0.0, color=GREY, lw=THIN)
    for part, colour in ((holds, WITH), (~holds, WITHOUT)):
        axes.vlines(k[part], low[part], high[part], color=colour, lw=1.2)
        axes.plot(k[part], value[part], "o", ms=2.0, color=colour)
    axes.set_yscale("symlog", linthresh=even, linscale=2.0)
    axes.set_ylim(-limit, limit)
    axes.set_yticks([-limit / 1.2, -0.6 * even, 0.0, 0.6 * even, limit / 1.2])
    axes.yaxis.set_major_formatter(FuncFormatter(lambda x, _: number(x, 2)))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.set_xlim(0.0, len(rows) + 1.0)
    axes.xaxis.get_major_locator().set_params(integer=True)
    said = meaning(name)
    axes.set_ylabel("Error [%]")
    axes.set_title(f"{said[0].upper()}{said[1:]}: {holds.sum()} of {len(rows)} hold the truth")


if __name__ == "__main__":
    main()
