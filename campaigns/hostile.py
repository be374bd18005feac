"""``python -m campaigns.hostile [GROUP ...]``: what FMPy does with the malformed inputs.

Prints the table of ``docs/hostile.md``, which says what the words mean, and each case on standard
error. What stickslip does with them, ``tests/hostile/test_cases.py`` tests.
"""

import argparse
import linecache
import resource
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any

from stickslip.studies.survey.runs import RunOutcome, apart
from tests.corpus.hostile import CASES, GROUPS, Case

MEMORY = 4 * 2**30
"""Address space of FMPy's process [bytes]."""
PATIENCE = 10.0
"""How long FMPy may take for one file [s]."""
NONE = "no counterpart"
KINDS = ("crashes", "hangs", "ends silently", "runs", "Python error", "own message", NONE)


def feed(given: dict[str, Any]) -> Iterator[RunOutcome]:
    """Run a file as users of FMPy do, in a process of its own; tell which of `KINDS` it is."""
    import fmpy
    from fmpy.ssp.simulation import simulate_ssp
    from fmpy.util import read_csv

    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    kind, file, table = "runs", given.pop("file"), given.pop("input")
    try:
        if file.endswith(".ssp"):
            simulate_ssp(file, **{name: given[name] for name in given if name != "start_values"})
        else:
            if "step_size" in given:
                given["output_interval"] = given["step_size"]
            fmpy.simulate_fmu(file, input=read_csv(table) if table else None, **given)
    except BaseException as error:  # noqa: BLE001 - whatever it is, it is the answer
        last = traceback.extract_tb(error.__traceback__)[-1]
        line = linecache.getline(last.filename, last.lineno or 0).strip()
        meant = "fmpy" in Path(last.filename).parts and line.startswith("raise")
        kind = "own message" if meant else "Python error"
    yield RunOutcome(kind)


def kind_of(case: Case) -> str:
    """Return what FMPy does with a case: it may crash, hang, fork and flood."""
    with tempfile.TemporaryDirectory(prefix="hostile-") as name:
        folder = Path(name)
        with warnings.catch_warnings(action="ignore"):
            job = _job(case.make(folder), folder)
        if job is None:
            return NONE
        for pipe in filter(Path.is_fifo, [*folder.rglob("*")]):  # FMPy is fed none of it
            pipe.unlink()
        found = apart(feed, job, limit=PATIENCE).fault
    if found.startswith("died: "):
        return "ends silently" if "status" in found else "crashes"
    return "hangs" if found == "out of time" else found


def _job(arguments: Sequence[str], folder: Path) -> dict[str, object] | None:
    """Return the FMU or package of a command and how it is run; None where there is none."""
    files = [a for a in arguments if a.endswith((".fmu", ".ssp")) and (folder / a).exists()]
    if not files:
        return None
    follows = dict(pairwise(arguments))
    values = (a.partition("=") for a in arguments if "=" in a and not a.startswith("-"))
    job: dict[str, object] = {
        "file": str(folder / files[0]),
        "input": str(folder / follows["--input"]) if "--input" in follows else None,
        "start_values": {name.rpartition(".")[2]: value for name, _, value in values},
    }
    for option, name in (("--stop", "stop_time"), ("--step", "step_size")):
        with suppress(KeyError, ValueError):
            job[name] = float(follows[option])
    return job


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("groups", nargs="*", type=int, metavar="GROUP")
    parser.add_argument("--workers", type=int, default=1, metavar="N")
    options = parser.parse_args()
    cases = [case for case in CASES if not options.groups or case.group in options.groups]
    print(f"|  | group | cases | {' | '.join(f'FMPy {kind}' for kind in KINDS)} |")
    print("|---|---|" + "---:|" * (len(KINDS) + 1))
    found = []
    with ThreadPoolExecutor(options.workers) as pool:
        for case, kind in zip(cases, pool.map(kind_of, cases), strict=True):
            print(f"{case}: {kind}", file=sys.stderr, flush=True)
            found.append((case.group, kind))
    for group, name in (*GROUPS.items(), ("", "**all**")):
        counts = Counter(kind for n, kind in found if group in (n, ""))
        cells = (group, name, counts.total(), *(counts[kind] or "" for kind in KINDS))
        if counts:
            print(f"| {' | '.join(map(str, cells))} |")


if __name__ == "__main__":
    main()
