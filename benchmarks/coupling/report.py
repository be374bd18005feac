"""The ring of three FMUs: cosim, C loops and every peer that pip installs, in one run."""

import csv
from pathlib import Path

from benchmarks.coupling import growth
from benchmarks.coupling.figure import draw
from benchmarks.coupling.steps import (
    CANDIDATE_IN_TURN,
    CANDIDATE_LOOP,
    IN_TURN,
    PLAIN,
    measure_candidate,
    measure_peers,
)
from benchmarks.coupling.steps import measure as measure_steps

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
        f"FMI {version}.0, {coupling}": growth.by_fmus(folder, version, coupling)
        for version in (2, 3)
        for coupling in ("jacobi", "gauss_seidel")
    }
    for label, costs in grown.items():
        rows += [(f"per FMU, {label}", f"{n} FMUs", cost, "ns") for n, cost in costs.items()]
        growing = max(costs.values()) / costs[3]
        rows.append((f"per FMU, {label}", "dearest / 3 FMUs", growing, "x"))
    for label, costs in {
        "outputs more each": growth.by_variables(folder),
        "steps": growth.by_steps(folder),
    }.items():
        rows += [(f"per FMU, by {label}", f"{n} {label}", cost, "ns") for n, cost in costs.items()]
    rows.append(("threads", "speed of two / one", growth.by_threads(folder), "x"))
    _write(folder, rows)
    draw(folder / "coupling.png", drawn[2], grown)
    return {f"{group}: {name} ({unit})": value for group, name, value, unit in rows}


def _ratios(
    group: str, seconds: dict[str, float], loop: str, in_turn: str
) -> list[tuple[str, str, float, str]]:
    """Return rows of times divided by those of the C loops: in the same order, too."""
    rows = [(group, name, time / seconds[loop], "x C loop") for name, time in seconds.items()]
    turns = {name: time for name, time in seconds.items() if "Gauss-Seidel" in name}
    return rows + [
        (group, name, time / seconds[in_turn], "x C loop, Gauss-Seidel")
        for name, time in turns.items()
    ]


def _write(folder: Path, rows: list[tuple[str, str, float, str]]) -> None:
    head = ("measured", "case", "value", "unit")
    with (folder / "coupling.csv").open("w", newline="") as file:
        csv.writer(file).writerows([head, *rows])
    lines = ["# Cost of coupling, measured", ""]
    lines += ["| " + " | ".join(head) + " |", "|---|---|---|---|"]
    lines += [f"| {group} | {name} | {value:.3g} | {unit} |" for group, name, value, unit in rows]
    (folder / "coupling.md").write_text("\n".join(lines) + "\n")
