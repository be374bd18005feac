"""``stickslip compare``: results side by side, parameters and tracking errors.

stickslip compare axis-1 axis-2
stickslip compare axis-1 axis-2 --out compared
"""

import argparse
from pathlib import Path

from stickslip.commandline import add_options, require_files
from stickslip.output import Answer


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.description = (
        "Show what several results of learn, reproduce and fleet say, side by side: parameters "
        "with 95 % intervals, where they differ from the first result, and the simulated tracking "
        "errors. A value in parentheses is not identifiable."
    )
    parser.add_argument(
        "places", nargs="+", type=Path, metavar="DIR", help="folder of results, or learned.json"
    )
    add_options(parser, {"--out DIR": "folder for tables and page"}, type=Path)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> Answer:
    """Print two tables; write them with a page if there is a folder."""
    require_files(*options.places)
    from stickslip.presentation.markup import fill
    from stickslip.presentation.page import picture_files, write_page
    from stickslip.storage import reserved, staged
    from stickslip.storage.writing import write_tables
    from stickslip.studies.compare.compared import compare
    from stickslip.studies.compare.page import drives_sections

    files = ["parameters.csv", "errors.csv", *picture_files(["parameters"]), "compare.html"]
    with reserved(options.out, files):
        found = compare(options.places)
        print(f"{found.side_by_side().to_string()}\n")
        print(found.errors.text())
        if options.out is not None:
            command = {"name": "compare", "results": [str(place) for place in options.places]}
            with staged(options.out, command) as staging:
                frames = {"parameters": found.parameters.frame(), "errors": found.errors.frame()}
                write_tables(frames, staging)
                names = ", ".join(row["name"] for row in found.errors.rows)
                head = fill("<p>{{ names }}</p>", names=names)
                sections = drives_sections(found.parameters, head, "parameters", found.errors)
                write_page(staging, "Results side by side", sections, files[-1])
            print(f"\nall results are in {options.out}; open {files[-1]} first")
    return Answer({"parameters": found.parameters, "errors": found.errors})
