"""``python -m tests.corpus.defects``: who finds which seeded defect, as tables in Markdown."""

from __future__ import annotations

import tempfile
import warnings
from collections import Counter
from pathlib import Path

from stickslip import fmucheck
from tests.corpus.defects import binaries, descriptions, files
from tests.corpus.defects.peers import fmpy_complains, toolbox_complains
from tests.corpus.defects.reference import members, pack
from tests.corpus.defects.seed import Seed

SEEDS = [*files.SEEDS, *descriptions.SEEDS, *binaries.SEEDS]
RUNS = ("running", "rerunning", "ending")


def finders(seed: Seed) -> tuple[bool, bool, bool]:
    """Return who finds a defect: this tool by the right rule, FMPy, the toolbox."""
    with tempfile.TemporaryDirectory() as folder:
        path = seed.make(Path(folder))
        runs = fmucheck.RULES[seed.rule].stage in RUNS
        ours = seed.rule in fmucheck.check(path, run=runs, timeout=2.0).rules
        return ours, fmpy_complains(path), toolbox_complains(path)


def sound(version: int) -> tuple[bool, bool, bool]:
    """Return who complains about the sound FMU."""
    with tempfile.TemporaryDirectory() as folder:
        path = pack(Path(folder, "reference.fmu"), members(version))
        return bool(list(fmucheck.check(path))), fmpy_complains(path), toolbox_complains(path)


def main() -> None:
    """Print the counts by theme, then every defect."""
    found = {seed: finders(seed) for seed in SEEDS}
    print("| seeded into | defects | `stickslip check` | FMPy | fmu-manipulation-toolbox |")
    print("|---|---|---|---|---|")
    for theme in ("archive", "file", "description", "binary"):
        _row(theme, [who for seed, who in found.items() if seed.theme == theme])
    _row("all", list(found.values()))
    for version in (2, 3):
        alarms = " | ".join("yes" if alarm else "no" for alarm in sound(version))
        print(f"| nothing (FMI {version}.0): alarm? | 0 | {alarms} |")
    print("\n| rule | defect | FMI | `stickslip check` | FMPy | fmu-manipulation-toolbox |")
    print("|---|---|---|---|---|---|")
    for seed, who in found.items():
        marks = " | ".join("yes" if finds else "–" for finds in who)
        print(f"| `{seed.rule}` | {seed.what} | {seed.version}.0 | {marks} |")


def _row(name: str, rows: list[tuple[bool, bool, bool]]) -> None:
    counts = Counter(place for row in rows for place in range(3) if row[place])
    print(f"| {name} | {len(rows)} | {' | '.join(str(counts[place]) for place in range(3))} |")


if __name__ == "__main__":
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        main()
