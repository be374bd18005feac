"""The ring of three FMUs: cosim, C loops and every peer that pip installs, in one run."""

import csv
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import matplotlib as mpl
from matplotlib import pyplot as plt

from benchmarks.common import interleaved
from benchmarks.coupling import ring
from benchmarks.coupling.steps import (
    CANDIDATE_IN_TURN,
    CANDIDATE_LOOP,
    IN_TURN,
    PLAIN,
    measure_candidate,
    measure_peers,
)
from benchmarks.coupling.steps import measure as measure_steps

mpl.use("Agg")


def draw(path: Path, steps: dict[str, float], growth: dict[str, dict[int, float]]) -> None:
    """Draw ratios to the plain C loop (steps) and ns per FMU and step (growth)."""
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(13, 5), width_ratios=(1.2, 1), layout="constrained"
    )
    names = sorted(steps, key=steps.__getitem__, reverse=True)
    colours = ["#1b6ca8" if name.startswith("cosim") else "#9aa5b1" for name in names]
    bars = left.barh(names, [steps[name] for name in names], color=colours)
    left.bar_label(bars, fmt="%.3g", padding=3)
    left.set_xscale("log")
    left.margins(x=0.3)
    left.axvline(1.0, color="black", linewidth=0.8)
    left.set_xlabel("cost of a step / plain C loop in Jacobi order (1)")
    left.set_title("Ring of three FMI 2.0 FMUs, 100,000 steps")
    for label, costs in growth.items():
        right.plot(list(costs), list(costs.values()), "o-", label=label)
    right.set_xscale("log")
    right.set_ylim(bottom=0.0)
    right.set_xlabel("FMUs in the ring (1)")
    right.set_ylabel("cost of a step per FMU (ns)")
    right.set_title("Growth with the number of FMUs")
    right.legend()
    right.grid(alpha=0.3)
    figure.savefig(path, dpi=150)
    plt.close(figure)


FMUS = (3, 30, 300, 3000)
VARIABLES = (1, 10, 100, 1000)
STEPS = (1_000, 10_000, 100_000, 1_000_000)


def by_fmus(folder: Path, version: int, coupling: str) -> dict[int, float]:
    """Return ns per FMU and step: the difference of two runs, so without start and end."""
    return {
        n: _per_step(ring.system(folder, version, n), max(100, 300_000 // n), coupling) / n
        for n in FMUS
    }


def by_variables(folder: Path) -> dict[int, float]:
    """Return ns per FMU and step with so many recorded outputs more on each FMU."""
    return {
        n: _per_step(ring.system(folder, 2, 3, n), 200_000 // (n + 50), "jacobi", None) / 3
        for n in VARIABLES
    }


def by_steps(folder: Path) -> dict[int, float]:
    """Return ns per FMU and step of a whole run, start and end included."""
    system = ring.system(folder, 2)
    costs = {}
    for n in STEPS:
        seconds = interleaved({"run": _prepare(system, n, "jacobi").run}, 11, time.thread_time)
        costs[n] = seconds["run"] / n / 3 * 1e9
    return costs


def by_threads(folder: Path) -> float:
    """Return how much faster two threads are than one, on runs of 10 ms and more."""
    simulations = [_prepare(ring.system(folder, 2), 1_000_000, "jacobi") for _ in range(2)]

    def work(simulation) -> None:
        for _ in range(5):
            simulation.run()

    with ThreadPoolExecutor(1) as one, ThreadPoolExecutor(2) as two:
        seconds = interleaved(
            {
                "one": lambda: list(one.map(work, simulations)),
                "two": lambda: list(two.map(work, simulations)),
            },
            11,
        )
    return seconds["one"] / seconds["two"]


def _per_step(system, steps: int, coupling: str, record=("mass.v",)) -> float:
    once, twice = (_prepare(system, n, coupling, record) for n in (steps, 2 * steps))
    cases = {"once": once.run, "twice": twice.run}
    seconds = interleaved(cases, 25, time.thread_time, min, warm=2)
    return (seconds["twice"] - seconds["once"]) / steps * 1e9


def _prepare(system, steps: int, coupling: str, record=("mass.v",)):
    stop = steps * ring.STEP
    return system.prepare(step=ring.STEP, stop=stop, coupling=coupling, record=record)


NAMES = ("coupling.csv", "coupling.md", "coupling.png")


def measure(folder: Path) -> dict[str, float]:
    """Measure all, write the files of NAMES to the folder, and return the ratios."""
    rows: list[tuple[str, str, float, str]] = []
    drawn = {}
    for version in (2, 3):
        seconds = measure_steps(folder, version)
        if version == 2:
            seconds |= measure_peers(folder)
        drawn[version] = {name: time / seconds[PLAIN] for name, time in seconds.items()}
        rows += _ratios(f"step, FMI {version}.0", seconds, PLAIN, IN_TURN)
        seconds = measure_candidate(folder, version)
        rows += _ratios(f"candidate, FMI {version}.0", seconds, CANDIDATE_LOOP, CANDIDATE_IN_TURN)
    grown = {
        f"FMI {version}.0, {coupling}": by_fmus(folder, version, coupling)
        for version in (2, 3)
        for coupling in ("jacobi", "gauss_seidel")
    }
    for label, costs in grown.items():
        rows += [(f"per FMU, {label}", f"{n} FMUs", cost, "ns") for n, cost in costs.items()]
        rows.append((f"per FMU, {label}", "3000 FMUs / 30 FMUs", costs[3000] / costs[30], "x"))
    for label, costs in {
        "outputs more each": by_variables(folder),
        "steps": by_steps(folder),
    }.items():
        rows += [(f"per FMU, by {label}", f"{n} {label}", cost, "ns") for n, cost in costs.items()]
    rows.append(("threads", "speed of two / one", by_threads(folder), "x"))
    _write(folder, rows)
    draw(folder / "coupling.png", drawn[2], grown)
    return {f"{group}: {name} ({unit})": value for group, name, value, unit in rows}


def _ratios(
    group: str, seconds: dict[str, float], loop: str, in_turn: str
) -> list[tuple[str, str, float, str]]:
    """Return rows of times divided by that of the C loop of the same order."""
    rows = []
    for name, one in seconds.items():
        order, own = ("Gauss-Seidel", in_turn) if "Gauss-Seidel" in name else ("Jacobi", loop)
        rows.append((group, name, one / seconds[own], f"x C loop, {order}"))
    return rows


def _write(folder: Path, rows: list[tuple[str, str, float, str]]) -> None:
    head = ("measured", "case", "value", "unit")
    with (folder / "coupling.csv").open("w", newline="") as file:
        csv.writer(file).writerows([head, *rows])
    lines = ["# Cost of coupling, measured", ""]
    lines += ["| " + " | ".join(head) + " |", "|---|---|---|---|"]
    lines += [f"| {group} | {name} | {value:.3g} | {unit} |" for group, name, value, unit in rows]
    (folder / "coupling.md").write_text("\n".join(lines) + "\n")
