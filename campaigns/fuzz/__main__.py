"""``python -m campaigns.fuzz --parser NAME --inputs N --seed S``: a long hunt.

Inputs that end otherwise than they should are saved; ``--first`` goes on where a hunt was. A
process that died is told by its exit status and a traceback.
"""

import argparse
import faulthandler
import logging
import tempfile
from pathlib import Path

from campaigns.fuzz import PARSERS, campaign

ROUND, HANG = 1000, 600.0
"""Inputs, and the seconds for them after which the process ends with a traceback."""

if __name__ == "__main__":
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("--parser", choices=sorted(PARSERS), required=True)
    options.add_argument("--inputs", type=int, default=1_000_000)
    options.add_argument("--first", type=int, default=0)
    options.add_argument("--seed", type=int, default=0)
    options.add_argument("--out", type=Path, default=Path(tempfile.gettempdir()) / "fuzz")
    given = options.parse_args()
    found = given.out / f"{given.parser}-{given.seed}"
    found.mkdir(parents=True, exist_ok=True)
    faulthandler.enable()
    logging.disable()  # warnings about odd inputs are not what is looked for
    with tempfile.TemporaryDirectory() as name:
        for first in range(given.first, given.first + given.inputs, ROUND):
            faulthandler.dump_traceback_later(HANG, exit=True)
            last = min(first + ROUND, given.first + given.inputs)
            tally = campaign.run(
                PARSERS[given.parser], given.seed, first, last, Path(name), found=found
            )
            print(f"{first}: {tally}", *tally.unexpected, *tally.slow, sep="\n", flush=True)
