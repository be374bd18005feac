"""Commands as whole processes, CPU time: their start, a step of the ring, and checking a log."""

import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from time import process_time

from benchmarks.common import least
from benchmarks.coupling import ring
from stickslip import cosim
from stickslip.planning import plan

STEPS, REPEATS = 1_000_000, 7
STICKSLIP = (sys.executable, "-P", "-m", "stickslip")


def measure(folder: Path) -> dict[str, float]:
    """Return seconds of CPU, ns per step and ratios: the least of runs that take turns."""
    fmu, package, log = ring.build(folder, "mass", 2), folder / "ring.ssp", folder / "log.csv"
    cosim.write_ssp(ring.system(folder, 2), package)
    recorded = plan().rename(columns={"velocity_command": "velocity"})
    recorded.assign(force=recorded["velocity"]).to_csv(log, index=False)
    once = ("--stop", "1", "--step", "0.1")
    starts = {
        "--help": (*STICKSLIP, "--help"),
        "info": (*STICKSLIP, "info", fmu),
        "simulate": (*STICKSLIP, "simulate", fmu, *once),
        "simulate --no-isolate": (*STICKSLIP, "simulate", fmu, *once, "--no-isolate"),
        "learn --check": (*STICKSLIP, "learn", log, "--check"),
        "FMPy, info": (sys.executable, "-P", "-m", "fmpy", "info", fmu),
        "FMPy, simulate": (sys.executable, "-P", "-m", "fmpy", "simulate", fmu),
    }
    seconds = least({name: lambda c=c: cpu_of(c) for name, c in starts.items()}, REPEATS)
    found = {f"start: {name} (s)": one for name, one in seconds.items()}
    for name in ("info", "simulate"):
        found[f"start: {name} / FMPy"] = seconds[name] / seconds[f"FMPy, {name}"]
    found |= _steps(folder, package)
    return found


def _steps(folder: Path, package: Path) -> dict[str, float]:
    """Return ns per step: the difference of a run and one of three times as many steps."""
    loops = ring.Loops(2)
    options: dict[str, tuple[object, ...]] = {
        "": (),
        " --coupling jacobi": ("--coupling", "jacobi"),
        " --record mass.v": ("--record", "mass.v"),
        " --every 100": ("--every", "100"),
        " --last": ("--last",),
        " --no-isolate": ("--no-isolate",),
        " --out x.csv": ("--out", folder / "x.csv"),
    }
    del options[" --coupling jacobi"]
    cases: dict[str, Callable[[], float]] = {}
    for factor in (1, 3):
        n = factor * STEPS
        times = ("--stop", str(n * ring.STEP), "--step", str(ring.STEP))
        for name, more in options.items():
            command = (*STICKSLIP, "simulate", package, *times, *more)
            cases[f"simulate{name}", factor] = lambda c=command: cpu_of(c)
        cases["loop", factor] = lambda n=n: _timed(lambda: loops.in_turn(n))
    seconds = least(cases, REPEATS)
    ns = {n: 5e8 / STEPS * (seconds[n, 3] - seconds[n, 1]) for n, f in cases if f == 1}
    loop = ns.pop("loop")
    return {
        "step: plain C loop, Gauss-Seidel order (ns)": loop,
        **{f"step, Gauss-Seidel order: {name} (ns)": one for name, one in ns.items()},
        **{f"step, Gauss-Seidel order: {name} / loop": one / loop for name, one in ns.items()},
    }


def cpu_of(command: Sequence[object]) -> float:
    """Return the CPU seconds of a command and of the processes that it starts."""
    process = subprocess.Popen([*map(str, command)], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{command}: status {process.returncode}")
    return usage.ru_utime + usage.ru_stime


def _timed(call: Callable[[], object]) -> float:
    begin = process_time()
    call()
    return process_time() - begin
