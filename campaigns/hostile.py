"""``python -m campaigns.hostile [GROUP ...]``: what FMPy does with the malformed inputs.

Prints the table of ``docs/hostile.md``, which says what the words mean, and each case on standard
error. What stickslip does with them, ``tests/hostile/test_cases.py`` tests.
"""

import argparse
import json
import linecache
import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any

from tests.corpus.hostile import CASES, GROUPS, Case

MEMORY = 4 * 2**30
"""Address space of FMPy's process [bytes]."""
PATIENCE = 10.0
"""How long FMPy may take for one file [s]."""
NONE = "no counterpart"
KINDS = ("crashes", "hangs", "ends silently", "runs", "Python error", "own message", NONE)
CHILD = "import sys; from campaigns.hostile import feed; feed(*sys.argv[1:])"


def feed(job: str, answer: str) -> None:
    """Run a file as users of FMPy do, in a process of its own; write which of `KINDS` it is."""
    import fmpy
    from fmpy.ssp.simulation import simulate_ssp
    from fmpy.util import read_csv

    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    kind = "runs"
    try:
        given: dict[str, Any] = json.loads(job)
        file, table = given.pop("file"), given.pop("input")
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
    Path(answer).write_text(kind, encoding="utf-8")


def kind_of(case: Case) -> str:
    """Return what FMPy does with a case: it may crash, hang, fork and flood."""
    with tempfile.TemporaryDirectory(prefix="hostile-") as name:
        folder, answer, temporary = (Path(name, part) for part in ("fed", "answer", "temporary"))
        folder.mkdir()
        temporary.mkdir()
        with warnings.catch_warnings(action="ignore"):
            job = _job(case.make(folder), folder)
        if job is None:
            return NONE
        for pipe in filter(Path.is_fifo, [*folder.rglob("*")]):  # FMPy is fed none of it
            pipe.unlink()
        search = os.pathsep.join((str(Path(__file__).parents[1]), *filter(None, sys.path)))
        process = subprocess.Popen(
            [sys.executable, "-P", "-c", CHILD, json.dumps(job), str(answer)],
            cwd=folder,
            env=os.environ | {"TMPDIR": str(temporary), "PYTHONPATH": search},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        status = None
        with suppress(subprocess.TimeoutExpired):
            status = process.wait(PATIENCE)
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)  # and all that it forked
        process.wait()
        shutil.rmtree(temporary, ignore_errors=True)
        if status is None:
            return "hangs"
        if status < 0:
            return "crashes"
        return answer.read_text(encoding="utf-8") if answer.exists() else "ends silently"


def _job(arguments: Sequence[str], folder: Path) -> dict[str, object] | None:
    """Return the FMU or package of a command and how it is run; None where there is none."""
    files = [a for a in arguments if a.endswith((".fmu", ".ssp")) and (folder / a).exists()]
    if not files:
        return None
    follows = dict(pairwise(arguments))
    values = (a.partition("=") for a in arguments if "=" in a and not a.startswith("-"))
    job: dict[str, object] = {
        "file": files[0],
        "input": follows.get("--input"),
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
