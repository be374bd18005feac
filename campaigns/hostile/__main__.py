"""``python -m campaigns.hostile [GROUP ...]`` prints what FMPy and stickslip do with each case.

The first table is that of ``docs/hostile.md``, which says what the words mean.
"""

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from campaigns.hostile.verdicts import KINDS, Verdict, verdicts_of
from tests.corpus.hostile import CASES, GROUPS, Case

Row = tuple[Case, Verdict, Verdict]


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
    """Return the table of groups, and one for each group."""
    groups = {n: [row for row in found if row[0].group == n] for n in GROUPS}
    lines = [
        _line("", "group", "cases", *(f"FMPy {kind}" for kind in KINDS), "ours: one line"),
    ]
    lines.append("|---|---|" + "---:|" * (len(KINDS) + 2))
    for n, of in groups.items():
        lines.append(_line(n, GROUPS[n], *_counts(of)))
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


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("groups", nargs="*", type=int, metavar="GROUP")
    parser.add_argument("--workers", type=int, default=1, metavar="N")
    options = parser.parse_args()
    cases = [case for case in CASES if not options.groups or case.group in options.groups]
    found = rows(cases, options.workers)
    print(document(found))
    if bad := [case for case, _, ours in found if ours.kind != "one line"]:
        sys.exit(f"not one line: {', '.join(map(str, bad))}")


if __name__ == "__main__":
    main()
