"""``python -m campaigns.defects``: who finds which seeded defect, as tables in Markdown."""

import logging
import tempfile
import warnings
from collections import Counter
from pathlib import Path

from fmpy.validation import validate_fmu
from fmu_manipulation_toolbox.checker import get_checkers
from fmu_manipulation_toolbox.operations import FMU

from stickslip import fmucheck
from tests.corpus.defects import binaries, descriptions, files
from tests.corpus.defects.reference import Seed, members, pack


class _Counter(logging.Handler):
    """Counts warnings and errors."""

    count = 0

    def emit(self, record: logging.LogRecord) -> None:
        self.count += record.levelno >= logging.WARNING


def fmpy_complains(path: Path) -> bool:
    """Tell whether FMPy's validator reports a problem, be it by an exception."""
    try:
        return bool(validate_fmu(str(path)))
    except Exception:  # noqa: BLE001 (whatever it raises counts as found)
        return True


def toolbox_complains(path: Path) -> bool:
    """Tell whether the check of fmu-manipulation-toolbox reports a problem, likewise."""
    counter = _Counter()
    logger = logging.getLogger("fmu_manipulation_toolbox")
    logger.addHandler(counter)
    try:
        with FMU(str(path)) as fmu:
            for checker in get_checkers():
                fmu.apply_operation(checker())
    except (Exception, SystemExit):  # noqa: BLE001 (whatever it raises counts as found)
        return True
    finally:
        logger.removeHandler(counter)
    return counter.count > 0


SEEDS = [*files.SEEDS, *descriptions.SEEDS, *binaries.SEEDS]
RUNS = ("running", "rerunning", "ending")


def finders(seed: Seed) -> tuple[bool, bool, bool]:
    """Return who finds a defect: this tool by the right rule, FMPy, the toolbox."""
    with tempfile.TemporaryDirectory() as folder:
        path = seed.make(Path(folder))
        runs = fmucheck.RULES[seed.rule].stage in RUNS
        rules = fmucheck.check(path, run=runs, timeout=2.0).rules
        if "rule-not-tried" in rules:
            raise RuntimeError(f"{seed.name}: a rule could not be tried")
        return seed.rule in rules, fmpy_complains(path), toolbox_complains(path)


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
