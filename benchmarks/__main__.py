"""Speed as ratios inside one run: ``python -m benchmarks [NAME ...]``. Absolute times vary."""

import sys
import tempfile
from pathlib import Path

from benchmarks import container, description, firmware, isolation, learn, many_runs, workers
from benchmarks.coupling import report
from benchmarks.learning import speed
from benchmarks.timing import table

BENCHMARKS = {
    "coupling": report,
    "container": container,
    "workers": workers,
    "isolation": isolation,
    "description": description,
    "many_runs": many_runs,
    "firmware": firmware,
    "learn": learn,
    "speed": speed,
}

if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        for name in sys.argv[1:] or BENCHMARKS:
            benchmark = BENCHMARKS[name]
            print(f"\n{benchmark.__doc__.strip()}\n{table(benchmark.measure(Path(folder)))}")
