"""``stickslip survey``: run every FMU and system below a folder, and compare with FMPy.

stickslip survey fmus
stickslip survey fmus --with fmpy --out surveyed
"""

import argparse
import csv
import io
from collections import Counter
from pathlib import Path

from stickslip.commandline import add_options, at_least, require_files, seconds
from stickslip.errors import UsageError
from stickslip.fmi.files import atomic_write
from stickslip.output import Answer

FILE, PAGE = "survey.csv", "survey.html"


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.description = (
        "Run each FMU, by each of its interfaces, and each .ssp file below a folder, twice and to "
        "its stop time, in a process of its own. A row tells whether it ran or was refused, and "
        "with FMPy how far the outputs of both are apart."
    )
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument("--with", dest="other", choices=("fmpy",), help="also run it in this tool")
    add_options(parser, {"--out DIR": f"folder for {FILE} and {PAGE}"}, type=Path)
    limit = {"--timeout S": "time limit of each process (default 60)"}
    add_options(parser, limit, type=seconds, default=60.0)
    many = {"--workers N": "runs at a time (default 1)"}
    add_options(parser, many, type=at_least(1), default=1)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> Answer:
    """Print a row for each run and the number of each outcome."""
    require_files(options.folder)
    from stickslip.fmi.process import Threads
    from stickslip.studies.survey.runs import COLUMNS, TOOLS, surveyed, tasks

    folder = options.folder.absolute()  # runs have working folders of their own
    found = list(tasks(folder))
    if not found:
        raise UsageError(f"{options.folder}: there is no .fmu and no .ssp file in it")
    rows = []
    with Threads(options.workers) as pool:
        for row in pool.each(
            lambda task: surveyed(folder, task, options.timeout, fmpy=options.other == "fmpy"),
            found,
        ):
            print("  ".join(filter(None, row)), flush=True)
            rows.append(row)
    counts = Counter(row[2] for row in rows)
    works = sum(not row[5] for row in rows)
    also = f", {sum(not row[6] for row in rows)} in FMPy" if options.other else ""
    summary = f"{len(rows)} runs; {works} work here{also}"
    print(f"\n{summary}")
    for outcome, n in counts.most_common():
        print(f"{n:5}  {outcome}")
    if options.out:
        from stickslip.presentation.page import Section, write_page
        from stickslip.presentation.table import Column, Table

        table = io.StringIO()
        csv.writer(table).writerows([COLUMNS, *rows])
        options.out.mkdir(parents=True, exist_ok=True)
        print(atomic_write(options.out / FILE, table.getvalue()))
        records = [dict(zip(COLUMNS, row, strict=True)) for row in rows]
        faults = [f"{r['file']}: {name}: {r[name]}" for r in records for name in TOOLS if r[name]]
        counted = [{"outcome": outcome, "runs": str(n)} for outcome, n in counts.most_common()]
        tables = {
            summary: Table([Column(name, head=name) for name in ("outcome", "runs")], counted),
            "Runs": Table([Column(n, head=n) for n in COLUMNS if n not in TOOLS], records),
        }
        content = (
            "{% for title, table in tables.items() %}{{ table.html(title) }}{% endfor %}"
            '<div style="overflow-wrap: anywhere">{{ list(faults) }}</div>'
        )
        head = Section("", content, tables=tables, faults=faults)
        print(*write_page(options.out, f"FMUs of {options.folder.resolve().name}", [head], PAGE))
    return Answer(
        {"runs": [dict(zip(COLUMNS, row, strict=True)) for row in rows], "counts": counts}
    )
