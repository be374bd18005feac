"""``stickslip phenomena``: compute which phenomena of friction each law shows."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path

from stickslip import models
from stickslip.evaluation.phenomena import PHENOMENA, phenomena
from stickslip.fmi.files import atomic_write


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    laws = models.law_names()
    parser.add_argument("laws", nargs="*", metavar="LAW", help=f"of {', '.join(laws)}; default all")
    parser.add_argument(
        "--published",
        metavar="FILE.png",
        type=Path,
        help="draw the experiments of the paper that introduced LuGre, Canudas de Wit 1995",
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Print a row for each phenomenon and a column for each law, or draw the published figures."""
    if options.published:
        from stickslip.report.canudas_1995 import draw_published  # late, for matplotlib is slow

        atomic_write(options.published, draw_published())
        return
    laws = options.laws or models.law_names()
    print(table_of({law: phenomena(models.load_law(law).name) for law in laws}))


def table_of(found: Mapping[str, Mapping[str, float]]) -> str:
    """Return the table of laws and what each shows, as printed."""
    widths = {law: max(len(law), 8) for law in found}
    titles = [f"{law:>{width}}" for law, width in widths.items()]
    lines = ["  ".join([f"{'':40} {'':4}", *titles])]
    for name, (unit, _, _) in PHENOMENA.items():
        values = [
            f"{round(found[law][name], 4) + 0.0:>{width}.4g}" for law, width in widths.items()
        ]
        lines.append("  ".join([f"{name:40} {unit:4}", *values]))
    return "\n".join(lines)
