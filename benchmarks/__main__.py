"""Speed as ratios inside one run: ``python -m benchmarks [NAME ...]``. Absolute times vary.

Figures are printed. ``--write`` also replaces ``results/coupling`` by what was measured.
"""

import argparse
import shutil
import tempfile
from pathlib import Path

from benchmarks import candidates, commands, isolation, learn, sweeps
from benchmarks.common import table
from benchmarks.coupling import report

BENCHMARKS = {
    "coupling": report,
    "learn": learn,
    "learning": candidates,
    "isolation": isolation,
    "commands": commands,
    "sweeps": sweeps,
}
KEPT = Path(__file__).parents[1] / "results" / "coupling"


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(BENCHMARKS))
    parser.add_argument("--write", action="store_true", help="replace results/coupling")
    options = parser.parse_args()
    if unknown := set(options.names) - BENCHMARKS.keys():
        parser.error(f"no benchmark is called {', '.join(sorted(unknown))}")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for chosen in options.names or BENCHMARKS:
            module = BENCHMARKS[chosen]
            print(f"\n{module.__doc__.strip()}\n{table(module.measure(folder))}")
            if chosen == "coupling" and options.write:
                for file in report.NAMES:
                    shutil.copy(folder / file, KEPT)


if __name__ == "__main__":
    main()
