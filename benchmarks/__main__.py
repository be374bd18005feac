"""Speed as ratios inside one run: ``python -m benchmarks``. Absolute times vary by machine."""

import tempfile
from pathlib import Path

from benchmarks import candidate, container, description, firmware, isolation, many_runs, workers
from benchmarks.coupling import report
from benchmarks.learning import speed

BENCHMARKS = (
    report,
    candidate,
    container,
    workers,
    isolation,
    description,
    many_runs,
    firmware,
    speed,
)

if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        for benchmark in BENCHMARKS:
            print(f"\n{benchmark.__doc__.strip()}")
            for name, ratio in benchmark.measure(Path(folder)).items():
                print(f"  {name:76} {ratio:8.2f}")
