"""How often the 95 % intervals of what is learned hold the truth.

    python -m campaigns.interval_coverage --drives any --recordings 200 --workers 2 --out coverage

Each recording is simulated with noise and a seed of its own and learned like a log: of Table 2's
drive (``same``), of LuGre drives (``varied``), or of drives of every law with imperfections and
with right, wrong or no gains of the controller (``any``; ``random_drives.py`` defines what is true
of them). coverage.csv has a row for each quantity and recording and is rewritten after each;
recordings that it has are not learned again. The summary gives for each quantity the share that
holds with its 95 % bounds (Clopper and Pearson), and the median relative half-width.
"""

import argparse
import io
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, NullLocator
from scipy.stats import binomtest

from campaigns.random_drives import RandomDrive, random_drive
from campaigns.random_drives import record as record_random
from stickslip.catalog.parameters import PAPER, unit_of
from stickslip.errors import StickslipError
from stickslip.identification.estimation import (
    Estimation,
    LearnSettings,
    Task,
    candidate_fmus,
    learn,
)
from stickslip.identification.fitting.identifiability import NOT_IDENTIFIABLE, Identifiability
from stickslip.identification.sliding.friction_curve import Interval
from stickslip.logs import Recording
from stickslip.planning import plan
from stickslip.presentation.quantity import meaning, number
from stickslip.presentation.style import (
    GREY,
    PAGE,
    RESOLUTION,
    THIN,
    WITH,
    WITHOUT,
    house_style,
    new_figure,
)
from stickslip.rigs.contract import COMMISSIONING
from stickslip.servo.axis import Datasheet
from stickslip.servo.systems import servo_loop
from stickslip.servo.velocity_loop import VelocityLoop, design_velocity_loop
from stickslip.studies.learn.recorded import gains_of

MASS = (3.0, 12.0)  # [kg]
F_C = (2.0, 12.0)  # [N]
RISE = (1.1, 2.0)  # F_s / F_c
SIGMA_0 = (1e5, 1e6)  # [N/m], evenly in its logarithm
EVEN = 3.0
"""Median half-widths up to which the axis of the picture is linear; beyond, logarithmic."""
DAMPING = (0.3, 2.0)  # sigma_1 / (2 sqrt(sigma_0 m))
SPEEDS = 5
"""Speeds of the friction curve that count, from the lowest to the highest."""


def main() -> None:
    """Simulate, learn, count."""
    parser = argparse.ArgumentParser(
        prog="python -m campaigns.interval_coverage", description=__doc__
    )
    parser.add_argument("--recordings", type=int, default=100, metavar="N")
    parser.add_argument("--drives", choices=("any", "varied", "same"), default="varied")
    parser.add_argument("--sound", action="store_true", help="any drive, but none with faults")
    parser.add_argument("--cascade", action="store_true", help="any drive, in a position loop")
    parser.add_argument("--own-law", action="store_true", help="learn the law that the drive has")
    parser.add_argument("--criterion", choices=("auto", "inverse model"), default="auto")
    parser.add_argument("--first", type=int, default=0, help="seed of the first recording")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    parser.add_argument("--out", type=Path, default=Path("coverage"), metavar="DIR")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    path = options.out / "coverage.csv"
    tables = [pd.read_csv(path, keep_default_na=False)] if path.exists() else []
    done = set(tables[0]["seed"]) if tables else set()
    every = range(options.first, options.first + options.recordings)
    seeds = [seed for seed in every if seed not in done]
    with ProcessPoolExecutor(options.workers, mp_context=get_context("spawn")) as pool:
        waiting = [pool.submit(learn_one, options, seed) for seed in seeds]
        for one in as_completed(waiting):
            try:
                table = one.result()
            except StickslipError as error:  # nothing was claimed that could be wrong
                print(f"refused: {error}", flush=True)
                continue
            tables.append(table)
            everything = pd.concat(tables).sort_values("seed", kind="stable")
            everything.to_csv(path, index=False, lineterminator="\n")
            row = table.iloc[0]
            missed = ", ".join(table.parameter[~table.holds]) or "none"
            print(
                f"{row.seed:5} {row.seconds:6.1f} s  {row.law:16} {row.criterion:13} "
                f"missed: {missed}",
                flush=True,
            )
    everything = pd.concat(tables)
    if options.drives != "any":
        (options.out / "coverage.png").write_bytes(draw(everything))
    print(f"\n{everything.seed.nunique()} recordings\n" + summary(everything).to_string())


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """Return coverage by quantity, by law and by imperfection."""
    parts = {"all": table}
    if "imperfections" in table:
        parts |= dict(iter(table.groupby("law")))
        parts |= {f"gains {gains}": rows for gains, rows in table.groupby("gains")}
        names = sorted({name for each in table.imperfections for name in each.split()})
        parts |= {name: table[table.imperfections.str.contains(name)] for name in names}
        parts["none"] = table[table.imperfections == ""]
    rows = []
    for part, chosen in parts.items():
        for name, each in chosen.groupby("quantity", sort=False):
            n, held = each.seed.nunique(), each.holds.mean()
            bounds = binomtest(round(held * n), n).proportion_ci(method="exact")
            identifiable = each[each.identifiability != NOT_IDENTIFIABLE]
            rows.append(
                {
                    "drives": part,
                    "quantity": name,
                    "recordings": n,
                    "holds": f"{held:.1%}",
                    "bounds": f"{bounds.low:.0%} to {bounds.high:.0%}",
                    "half-width": f"{np.median(each.width):.2%}",
                    "identifiable": f"{identifiable.holds.mean():.1%} of {len(identifiable)}",
                }
            )
    return pd.DataFrame(rows).set_index(["drives", "quantity"])


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


def learn_one(options: argparse.Namespace, seed: int) -> pd.DataFrame:
    """Return a row for each quantity of one recording."""
    if options.drives == "any":
        made = random_drive(seed, cascade=options.cascade, sound=options.sound)
        recording, gains = record_random(made, seed)
    else:
        truth, sheet = drive(options.drives, seed), Datasheet()
        loop = design_velocity_loop(sheet.axis(sheet.mass, 0.0), COMMISSIONING)
        made = RandomDrive(parameters=truth)
        with candidate_fmus() as fmus:
            recording, gains = record(fmus, loop, truth, seed), gains_of(loop)
    begin = time.process_time()
    law = made.law if options.own_law else "lugre"
    with candidate_fmus(law) as fmus:
        settings = LearnSettings(law, options.criterion, seed)
        estimation = learn(Task(fmus, recording, gains, settings))
    told = {1.0: "right", 0.0: "none"}.get(made.gains, "wrong")
    return pd.DataFrame(_rows(made, estimation)).assign(
        seed=seed,
        law=made.law,
        imperfections=" ".join(made.imperfections),
        gains=told,
        criterion=estimation.criterion,
        reason=estimation.reason,
        model_error=estimation.model_error,
        seconds=round(time.process_time() - begin, 1),
    )


def _rows(drive: RandomDrive, estimation: Estimation) -> Iterator[dict[str, object]]:
    travel, known = estimation.recording.position, estimation.known
    truth = drive.along(travel)
    if drive.law != estimation.law.name:  # its own parameters mean nothing to the other law
        known = {name: known[name] for name in ("m", "b")}
    for name, found in known.items():
        if name in truth:
            yield _row(name, unit_of(name), truth[name], found, abs(truth[name]))
    curve = estimation.friction_curve
    if curve is None:
        return
    yield _row("offset", "N", drive.offset(travel), curve.offset, truth["F_c"])
    for k in np.linspace(0, len(curve.speed) - 1, SPEEDS).round().astype(int):
        value, low, high = (float(one[k]) for one in (curve.value, curve.low, curve.high))
        true = float(drive.friction(curve.speed[k], travel))
        row = _row("F(v)", "N", true, Interval(value, float("nan"), low, high), true)
        yield {**row, "parameter": f"F({1e3 * curve.speed[k]:.3g} mm/s)"}


def _row(
    name: str, unit: str, truth: float, found: Identifiability | Interval, size: float
) -> dict[str, object]:
    return {
        "parameter": name,
        "quantity": name,
        "unit": unit,
        "truth": truth,
        "value": found.value,
        "standard_error": found.standard_error,
        "low": found.low,
        "high": found.high,
        "width": 0.5 * (found.high - found.low) / size,
        "identifiability": getattr(found, "identifiability", ""),
        "holds": found.low <= truth <= found.high,
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
