"""``python -m campaigns.fuzz --parser NAME --inputs N --seed S``: a long hunt.

Run again with the same seed it goes on where it was; inputs that end otherwise than they should
are saved beside the counts. A process that died is told by its exit status and a traceback.
"""

import argparse
import faulthandler
import logging
import tempfile
from pathlib import Path

from campaigns.fuzz import PARSERS, campaign

if __name__ == "__main__":
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("--parser", choices=sorted(PARSERS), required=True)
    options.add_argument("--inputs", type=int, default=1_000_000)
    options.add_argument("--seed", type=int, default=0)
    options.add_argument("--out", type=Path, default=Path(tempfile.gettempdir()) / "fuzz")
    given = options.parse_args()
    faulthandler.enable()
    logging.disable()  # warnings about odd inputs are not what is looked for
    with tempfile.TemporaryDirectory() as folder:
        campaign.resume(
            PARSERS[given.parser],
            given.seed,
            given.inputs,
            given.out / f"{given.parser}-{given.seed}",
            Path(folder),
        )
