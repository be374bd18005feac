"""``stickslip phenomena``: compute which phenomena of friction each law shows."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from stickslip import models
from stickslip.errors import UsageError
from stickslip.fmi.files import atomic_write
from stickslip.output import Answer

if TYPE_CHECKING:
    import pandas as pd


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


def run(options: argparse.Namespace) -> Answer:
    """Print a row for each phenomenon and a column for each law, or draw the published figures."""
    if options.published:
        if options.published.suffix.lower() != ".png":
            raise UsageError(f"{options.published}: expected a file name that ends in .png")
        from stickslip.papers.lugre.canudas_page import draw_published

        return Answer({"written": [atomic_write(options.published, draw_published())]})
    from stickslip.papers.lugre.phenomena import phenomena

    found = phenomena(*options.laws)
    print(table_of(found))
    return Answer({"phenomena": found.reset_index()})


def table_of(found: pd.DataFrame) -> str:
    """Return the table of laws and what each shows, as printed."""
    widths = {str(law): max(len(str(law)), 8) for law in found}
    titles = [f"{law:>{width}}" for law, width in widths.items()]
    lines = ["  ".join([f"{'':40} {'':4}", *titles])]
    for (name, unit), *row in found.itertuples():
        values = [
            f"{round(value, 4) + 0.0:>{width}.4g}"
            for value, width in zip(row, widths.values(), strict=True)
        ]
        lines.append("  ".join([f"{name:40} {unit:4}", *values]))
    return "\n".join(lines)
