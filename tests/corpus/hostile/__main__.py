"""``python -m tests.corpus.hostile [GROUP ...]`` writes docs/hostile.md, or prints some groups."""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import fmpy

from stickslip.fmi.files import atomic_write
from tests.corpus.hostile import CASES, GROUPS, Case
from tests.corpus.hostile.verdicts import KINDS, LONGEST, PATIENCE, Verdict, verdicts_of

DOCUMENT = Path(__file__).parents[3] / "docs" / "hostile.md"

Row = tuple[Case, Verdict, Verdict]

HEAD = f"""# Malformed input

FMUs are native code from other tools, and logs come from many sources. The page lists the
malformed files, folders, answers and arguments with which `tests/corpus/hostile` runs `stickslip`,
or its functions from Python, by the reader that they concern. Each case ends in one line on standard error and status 1 or 2, and leaves
nothing behind. `python -m tests.corpus.hostile` writes this page.

The second column is what FMPy {fmpy.__version__} does with the same file, in a process with 4
GB of memory and {PATIENCE:g} s of time, through `simulate_fmu`, `simulate_ssp` and `read_csv`
with their defaults. The words are assigned automatically: *crashes*, a signal ended the
process; *hangs*, it was still running; *ends silently*, the process ended without returning;
*runs*, no complaint; *own message*, an exception that FMPy raises itself; *Python error*, an
exception from elsewhere that passed through it; *no counterpart*, FMPy has no such command.
Lines are shortened to {LONGEST} characters.
"""


def rows(cases: Iterable[Case], workers: int) -> list[Row]:
    """Feed all cases to both."""
    with tempfile.TemporaryDirectory(prefix="hostile-cache-") as cache:

        def one(case: Case) -> Row:
            row = (case, *verdicts_of(case, Path(cache)))
            print(f"{case}: {row[1].words} | {row[2].words}", file=sys.stderr, flush=True)
            return row

        with ThreadPoolExecutor(workers) as pool:
            return list(pool.map(one, cases))


def document(found: list[Row]) -> str:
    """Return the page."""
    groups = {n: [row for row in found if row[0].group == n] for n in GROUPS}
    lines = [
        HEAD,
        _line("", "group", "cases", *(f"FMPy {kind}" for kind in KINDS), "ours: one line"),
    ]
    lines.append("|---|---|" + "---:|" * (len(KINDS) + 2))
    for n, of in groups.items():
        lines.append(_line(n, f"[{GROUPS[n]}](#{_anchor(n)})" if of else GROUPS[n], *_counts(of)))
    lines.append(_line("", "**all**", *_counts(found)))
    for n, of in groups.items():
        if of:
            lines += ["", f"## {n}. {GROUPS[n]}", ""]
            lines += [_line("case", "FMPy", "stickslip"), "|---|---|---|"]
            lines += [_line(case.about, theirs.words, ours.words) for case, theirs, ours in of]
    return "\n".join(lines) + "\n"


def _counts(of: list[Row]) -> list[object]:
    kinds = Counter(theirs.kind for _, theirs, _ in of)
    good = sum(ours.kind == "one line" for *_, ours in of)
    return [len(of), *(kinds[kind] or "" for kind in KINDS), good]


def _line(*cells: object) -> str:
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def _anchor(n: int) -> str:
    return f"{n}-{GROUPS[n].lower().replace(' ', '-')}"


def main() -> None:
    """Write the page, if all groups are asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("groups", nargs="*", type=int, metavar="GROUP")
    parser.add_argument("--workers", type=int, default=1, metavar="N")
    options = parser.parse_args()
    cases = [case for case in CASES if not options.groups or case.group in options.groups]
    found = rows(cases, options.workers)
    if options.groups:
        print(document(found))
    else:
        print(atomic_write(DOCUMENT, document(found)))
    if bad := [case for case, _, ours in found if ours.kind != "one line"]:
        sys.exit(f"not one line: {', '.join(map(str, bad))}")


if __name__ == "__main__":
    main()
