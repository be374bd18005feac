"""Feeds FMPy what a case feeds us: ``fed_to_fmpy.py JOB.json``.

Runs in a process of its own, for much of it does not come back. The answer is written beside the
job: null if all went well, else the exception and whether FMPy meant to raise it.
"""

import json
import linecache
import resource
import sys
import traceback
from pathlib import Path
from typing import Any

MEMORY = 4 * 2**30
"""Address space [bytes]."""


def feed(job: dict[str, Any]) -> None:
    """Run a file as users of FMPy do."""
    import fmpy
    from fmpy.ssp.simulation import simulate_ssp
    from fmpy.util import read_csv

    times = {name: job[name] for name in ("stop_time", "step_size") if job.get(name) is not None}
    if job["file"].endswith(".ssp"):
        simulate_ssp(job["file"], **times)
        return
    if times.get("step_size"):
        times["output_interval"] = times["step_size"]
    given = read_csv(job["input"]) if job.get("input") else None
    fmpy.simulate_fmu(job["file"], input=given, start_values=job["start_values"], **times)


def told(error: BaseException) -> dict[str, Any]:
    """Return an exception; ``meant`` if a ``raise`` of FMPy's own was the cause."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    line = linecache.getline(last.filename, last.lineno or 0).strip()
    meant = "fmpy" in Path(last.filename).parts and line.startswith("raise")
    return {"type": type(error).__name__, "message": str(error), "meant": meant}


def main(path: Path) -> None:
    """Feed what the job says and write the answer."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    try:
        feed(json.loads(path.read_text(encoding="utf-8")))
        answer = None
    except BaseException as error:  # noqa: BLE001 - whatever it is, it is the answer
        answer = told(error)
    path.with_suffix(".answer").write_text(json.dumps(answer), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
