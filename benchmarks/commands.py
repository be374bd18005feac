"""Commands as whole processes, CPU time: their start, and what a step of the ring costs them."""

import os
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

from benchmarks.common import cpu, interleaved
from benchmarks.coupling import ring
from benchmarks.learn import write_log
from stickslip import cosim

STEPS, REPEATS = 2_000_000, 5
STICKSLIP = (sys.executable, "-P", "-m", "stickslip")
FMPY = (sys.executable, "-P", "-m", "fmpy")


def measure(folder: Path) -> dict[str, float]:
    """Return seconds, ns per step and ratios: the least of runs that take turns."""
    fmu, log = ring.build(folder, "mass", 2), write_log(folder)[0]
    once = ("simulate", fmu, "--stop", "1", "--step", "0.1")
    starts = {
        "--help": (*STICKSLIP, "--help"),
        "info": (*STICKSLIP, "info", fmu),
        "simulate --no-isolate": (*STICKSLIP, *once, "--no-isolate"),
        "simulate --isolate": (*STICKSLIP, *once, "--isolate"),
        "learn --check": (*STICKSLIP, "learn", log, "--check"),
        "info by FMPy": (*FMPY, "info", fmu),
        "simulate by FMPy": (*FMPY, "simulate", fmu),
    }
    seconds = _least({name: partial(_run, *command) for name, command in starts.items()})
    found = {f"{name} (s)": one for name, one in seconds.items()}
    for name in (*starts,)[1:4]:
        found[f"{name} / FMPy"] = seconds[name] / seconds[f"{name.partition(' ')[0]} by FMPy"]
    return found | _steps(folder)


def _steps(folder: Path) -> dict[str, float]:
    """Return the cost of a step: the difference of a run and one of three times as many steps."""
    cosim.write_ssp(ring.system(folder, 2), package := folder / "ring.ssp")
    loops = ring.Loops(2)
    options: dict[str, tuple[object, ...]] = {
        "--no-isolate": ("--no-isolate",),
        "--isolate": ("--isolate",),
        "--isolate --record mass.v": ("--isolate", "--record", "mass.v"),
        "--isolate --every 100": ("--isolate", "--every", "100"),
        "--isolate --last": ("--isolate", "--last"),
        "--isolate --out x.csv": ("--isolate", "--out", folder / "x.csv"),
    }
    cases: dict[str, Callable[[], object]] = {}
    for n in (STEPS, 3 * STEPS):
        run = ("simulate", package, "--stop", n * ring.STEP, "--step", ring.STEP)
        cases |= {f"{name} {n}": partial(_run, *STICKSLIP, *run, *o) for name, o in options.items()}
        cases[f"loop {n}"] = partial(loops.in_turn, n)
    seconds = _least(cases)
    ns = {
        name: 1e9 * (seconds[f"{name} {3 * STEPS}"] - seconds[f"{name} {STEPS}"]) / (2 * STEPS)
        for name in (*options, "loop")
    }
    found = {"step of the plain C loop, Gauss-Seidel (ns)": ns["loop"]}
    for name in options:
        found[f"step of simulate {name}, Gauss-Seidel (ns)"] = ns[name]
        found[f"step of simulate {name} / loop, Gauss-Seidel"] = ns[name] / ns["loop"]
    return found


def _least(cases: dict[str, Callable[[], object]]) -> dict[str, float]:
    return interleaved(cases, REPEATS, cpu, min)


def _run(*command: object) -> None:
    """Run a command, with modules compiled as in an installation."""
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    subprocess.run([*map(str, command)], check=True, capture_output=True, env=kept)
