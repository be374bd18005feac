"""``stickslip phenomena``: compute which phenomena of friction each law shows."""

from __future__ import annotations

import argparse

from stickslip import models
from stickslip.evaluation.phenomena import PHENOMENA, phenomena


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    laws = models.law_names()
    parser.add_argument("laws", nargs="*", metavar="LAW", help=f"of {', '.join(laws)}; default all")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Print a row for each phenomenon and a column for each law."""
    laws = options.laws or models.law_names()
    found = {law: phenomena(models.load_law(law).name) for law in laws}
    widths = [max(len(law), 8) for law in laws]
    titles = [f"{law:>{width}}" for law, width in zip(laws, widths, strict=True)]
    print("  ".join([f"{'':40} {'':4}", *titles]))
    for name, (unit, _, _) in PHENOMENA.items():
        values = [
            f"{round(found[law][name], 4) + 0.0:>{width}.4g}"
            for law, width in zip(laws, widths, strict=True)
        ]
        print("  ".join([f"{name:40} {unit:4}", *values]))
