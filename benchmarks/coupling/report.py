"""The ring of three FMUs: cosim, C loops and every peer that pip installs, in one run."""

import csv
from pathlib import Path

from benchmarks.coupling import growth
from benchmarks.coupling.figure import draw
from benchmarks.coupling.steps import CANDIDATE_LOOP, PLAIN, measure_candidate, measure_peers
from benchmarks.coupling.steps import measure as measure_steps

OUT = Path("results/coupling")  # coupling.csv, coupling.md, coupling.png


def measure(folder: Path) -> dict[str, float]:
    """Measure all, write table and figure, and return the ratios."""
    rows: list[tuple[str, str, float, str]] = []
    drawn = {}
    for version in (2, 3):
        seconds = measure_steps(folder, version)
        if version == 2:
            seconds |= measure_peers(folder)
        ratios = {name: time / seconds[PLAIN] for name, time in seconds.items()}
        drawn[version] = ratios
        rows += [(f"step, FMI {version}.0", name, r, "x plain") for name, r in ratios.items()]
        seconds = measure_candidate(folder, version)
        loop = seconds[CANDIDATE_LOOP]
        for name, time in seconds.items():
            rows.append((f"candidate, FMI {version}.0", name, time / loop, "x C loop"))
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
    OUT.mkdir(parents=True, exist_ok=True)
    _write(rows)
    draw(OUT / "coupling.png", drawn[2], grown)
    return {f"{group}: {name} ({unit})": value for group, name, value, unit in rows}


def _write(rows: list[tuple[str, str, float, str]]) -> None:
    head = ("measured", "case", "value", "unit")
    with (OUT / "coupling.csv").open("w", newline="") as file:
        csv.writer(file).writerows([head, *rows])
    lines = ["# Cost of coupling, measured", ""]
    lines += ["| " + " | ".join(head) + " |", "|---|---|---|---|"]
    lines += [f"| {group} | {name} | {value:.3g} | {unit} |" for group, name, value, unit in rows]
    (OUT / "coupling.md").write_text("\n".join(lines) + "\n")
