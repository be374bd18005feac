"""Learning, measured: ``python -m benchmarks.learning --out DIR``; takes about an hour in full."""

import argparse
import tempfile
from functools import partial
from pathlib import Path

from benchmarks.learning import contest, race, scaling, speed
from benchmarks.learning.problem import KINDS
from benchmarks.timing import table

PARTS = ("speed", "scaling", "race", "functions", "further")


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.learning", description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("learning-benchmark"), metavar="DIR")
    parser.add_argument("--part", choices=PARTS, action="append", help="one or more; all if left")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--evaluations", type=int, default=1000)
    parser.add_argument("--problem", choices=KINDS, action="append", help="to race on; all if left")
    parser.add_argument("--genes", type=int, action="append", help="of functions; 5 and 10 if left")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    numbers = options.seeds, options.evaluations, options.genes or contest.DIMENSIONS
    function_race = partial(contest.run, options.out, *numbers)
    for part in options.part or PARTS:
        with tempfile.TemporaryDirectory() as temporary:
            folder = Path(temporary)
            measure, about = {
                "race": (
                    partial(
                        race.run,
                        folder,
                        options.out,
                        options.problem or list(KINDS),
                        options.seeds,
                        options.evaluations,
                    ),
                    race.__doc__,
                ),
                "functions": (partial(function_race, further=False), contest.__doc__),
                "further": (partial(function_race, further=True), contest.__doc__),
                "speed": (partial(speed.measure, folder, options.evaluations), speed.__doc__),
                "scaling": (partial(scaling.run, folder), scaling.__doc__),
            }[part]
            print(f"\n{about.strip()}")
            found = measure()
            if isinstance(found, dict):
                found = table(found)
            print(found, flush=True)
            text = f"{about.strip()}\n{found}\n"
            (options.out / f"{part}.txt").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
