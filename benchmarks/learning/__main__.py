"""Learning, measured: ``python -m benchmarks.learning --out DIR``; takes about an hour in full."""

import argparse
import tempfile
from functools import partial
from pathlib import Path

from benchmarks.common import table
from benchmarks.learning import contest, problem, race, speed

PARTS = ("speed", "scaling", "race", "functions", "further")


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.learning", description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("learning-benchmark"), metavar="DIR")
    parser.add_argument("--part", choices=PARTS, action="append", help="one or more; all if left")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--evaluations", type=int, default=1000)
    parser.add_argument(
        "--problem", choices=problem.KINDS, action="append", help="to race on; all if left"
    )
    parser.add_argument("--genes", type=int, action="append", help="of functions; 5 and 10 if left")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    numbers = options.seeds, options.evaluations
    kinds, genes = options.problem or list(problem.KINDS), options.genes or contest.DIMENSIONS
    function_race = partial(contest.run, options.out, *numbers, genes)
    measures = {
        "speed": (lambda folder: speed.measure(folder, options.evaluations), speed.__doc__),
        "scaling": (problem.scaling, problem.scaling.__doc__),
        "race": (lambda folder: race.run(folder, options.out, kinds, *numbers), race.__doc__),
        "functions": (lambda _: function_race(further=False), contest.__doc__),
        "further": (lambda _: function_race(further=True), contest.__doc__),
    }
    for part in options.part or PARTS:
        with tempfile.TemporaryDirectory() as temporary:
            measure, about = measures[part]
            print(f"\n{about.strip()}")
            found = measure(Path(temporary))
            if isinstance(found, dict):
                found = table(found)
            print(found, flush=True)
            text = f"{about.strip()}\n{found}\n"
            (options.out / f"{part}.txt").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
