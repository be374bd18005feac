"""What ``stickslip learn`` makes of faulty logs: right, flagged, refused, or confident and wrong.

    python -m campaigns.fault_matrix --seeds 3 --workers 2 --out faults
    python -m campaigns.fault_matrix --drives light gms --faults "one way only" --seeds 1

Drives of every friction law are recorded, each recording is damaged in every way of ``FAULTS``, and
learned, with the controller's gains and without. An outcome is *right* when mass, friction curve
and compensator agree with the drive, *flagged* when they do not and a warning that makes the values
doubtful names a fault which the sound log does not have, *refused* when no compensator would be
written, and else *confident and wrong*. matrix.csv is rewritten after each log; logs that it holds
are not learned again with --resume.
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import pandas as pd

from campaigns.fault_matrix.cells import CELL, OUTCOMES, check_all, learn_all
from campaigns.fault_matrix.drives import DRIVES
from campaigns.fault_matrix.faults import FAULTS


def main() -> None:
    """Record, damage, learn, count."""
    parser = argparse.ArgumentParser(
        prog="python -m campaigns.fault_matrix",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--drives", nargs="+", choices=DRIVES, default=list(DRIVES))
    parser.add_argument("--faults", nargs="+", choices=FAULTS, default=list(FAULTS))
    parser.add_argument("--seeds", type=int, default=3, metavar="N")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    parser.add_argument("--check", action="store_true", help="only check the logs, as learn does")
    parser.add_argument("--resume", action="store_true", help="keep the rows of matrix.csv")
    parser.add_argument("--out", type=Path, default=Path("faults"), metavar="DIR")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    path = options.out / "matrix.csv"
    rows: list[dict[str, object]] = []
    if options.resume and path.exists():
        rows = pd.read_csv(path, keep_default_na=False).to_dict("records")
    done = {tuple(row[name] for name in CELL) for row in rows}
    cells = [(name, seed) for seed in range(options.seeds) for name in options.drives]
    work = partial(check_all if options.check else learn_all, options.faults, done)
    with ProcessPoolExecutor(options.workers, mp_context=get_context("spawn")) as pool:
        for found in pool.map(work, *zip(*cells, strict=True)):
            rows += found
            pd.DataFrame(rows).to_csv(path, index=False, lineterminator="\n")
    table = pd.DataFrame(rows)
    count = pd.crosstab(table["fault"], table["outcome"])
    if not options.check:
        count = count.reindex(columns=list(OUTCOMES), fill_value=0)
    print("\n" + count.reindex(table["fault"].unique()).to_string())


if __name__ == "__main__":
    main()
