"""100,000 prepared runs and 2,000 preparations in one process: what they leave behind."""

import gc
import time
from pathlib import Path

from benchmarks.coupling import ring

RUNS, PREPARATIONS = 100_000, 2_000


def measure(folder: Path) -> dict[str, float]:
    system = ring.system(folder, 2)

    def prepare():
        return system.prepare(step=ring.STEP, stop=100 * ring.STEP, coupling="jacobi")

    with prepare() as simulation:
        for i in range(1_000):
            simulation.run({"controller.K_p": 40.0 + i})
        memory, files = resources()
        begin = time.perf_counter()
        for i in range(RUNS):
            simulation.run({"controller.K_p": 40.0 + i % 1_000})
        seconds = time.perf_counter() - begin
    after_runs, _ = resources()
    for _ in range(PREPARATIONS):
        prepare().close()
    after_all, files_after = resources()
    return {
        "run of 100 steps (us)": seconds / RUNS * 1e6,
        "memory more after all runs (kB)": after_runs - memory,
        "memory more after all preparations (kB)": after_all - after_runs,
        "open files more": files_after - files,
    }


def resources() -> tuple[float, int]:
    """Return the resident memory in kB and the number of open files; Linux only."""
    gc.collect()
    status = Path("/proc/self/status").read_text()
    memory = float(status.split("VmRSS:")[1].split()[0])
    return memory, len(list(Path("/proc/self/fd").iterdir()))
