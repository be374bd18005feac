"""Learning killed by SIGKILL at random moments and resumed: is it the uninterrupted run?"""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from benchmarks.learning.problem import cost, problem
from stickslip import ga

KILLS, EVALUATIONS = 20, 600


def run(folder: Path, out: Path) -> dict[str, float]:
    """Kill each algorithm, on threads and on processes, and compare history and checkpoint."""
    del out
    lines = {}
    with cost(folder / "fmus"):
        pass  # builds the FMUs before anyone is killed
    for algorithm in ga.ALGORITHMS:
        _start(folder, algorithm, "whole", "threads").wait()
        kills = 0
        for attempt in range(200):
            where = ("threads", "processes")[attempt % 2]
            if kills == KILLS:
                break
            kills += _killed(folder, algorithm, where, np.random.default_rng(attempt))
        _start(folder, algorithm, "killed", "threads").wait()
        same = all(
            (folder / f"{algorithm}-whole.{kind}").read_bytes()
            == (folder / f"{algorithm}-killed.{kind}").read_bytes()
            for kind in ("json", "csv")
        )
        if not same:
            raise RuntimeError(f"{algorithm}: the resumed run is another one")
        line = f"{algorithm}: times killed, and yet byte for byte the same"
        lines[line] = float(kills)
        print(f"  {line}: {kills}", flush=True)
    return lines


def _start(folder: Path, algorithm: str, name: str, where: str) -> subprocess.Popen[bytes]:
    arguments = [str(folder), algorithm, name, where]
    # Killed pools leave semaphores behind, of which their tracker would warn.
    command = [sys.executable, "-W", "ignore", "-m", "benchmarks.learning.survival"]
    return subprocess.Popen([*command, *arguments])


def _killed(folder: Path, algorithm: str, where: str, rng: np.random.Generator) -> bool:
    """Resume, let it run for a while, and kill it; return whether it was still running."""
    running = folder / "running"
    running.unlink(missing_ok=True)
    with _start(folder, algorithm, "killed", where) as process:
        while process.poll() is None and not running.exists():
            time.sleep(1e-3)
        time.sleep(rng.uniform(0.0, 0.2))
        was_running = process.poll() is None
        process.kill()
    if not was_running:  # it came to its end: begin again, with the kills counted so far
        for kind in ("json", "csv"):
            (folder / f"{algorithm}-killed.{kind}").unlink(missing_ok=True)
    return was_running


def _learn(folder: Path, algorithm: str, name: str, where: str) -> None:
    optimiser = ga.optimiser(
        algorithm,
        problem(0, constrained=algorithm != "paper"),
        ga.Limits(evaluations=EVALUATIONS),
        seed=1,
    )
    path = folder / f"{algorithm}-{name}"
    with cost(folder / "fmus") as judge, ga.executor(where, 2) as executor:
        (folder / "running").touch()
        ga.learn(optimiser, judge, executor, checkpoint=path.with_suffix(".json"), resume=True)
    optimiser.history.to_csv(path.with_suffix(".csv"))


if __name__ == "__main__":
    _learn(Path(sys.argv[1]), *sys.argv[2:])
