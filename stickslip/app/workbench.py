"""What all pages of the workbench share: the folder, and the jobs."""

import json
from collections.abc import Callable, Iterable
from contextlib import suppress
from itertools import count
from pathlib import Path
from typing import Any

from stickslip.app.jobs import RUNNING, Job, Lines, stamp

LOGS = {
    *(".csv", ".txt", ".tsv", ".dat", ".log", ".xlsx", ".parquet", ".mat", ".h5", ".hdf5"),
    *(".tdms", ".mf4"),
}
MODELS = {".fmu", ".ssp"}
LEARNED, PAGES = ("learned.json", "tuned.json"), ("report.html", "arena.html")
MOST = 2000  # files that are listed
GAINS = ("K_x", "K_p", "K_i", "m_ff")  # that tell loops apart
LOST = "the run ended with its server, unless that still runs"


def titled(folder: Path) -> str:
    """Return the name of a folder of results with its date, its logs and the gains of its loop."""
    parts = [folder.name]
    with suppress(OSError, ValueError, KeyError, TypeError, AttributeError, StopIteration):
        parts.append(stamp(folder.stat().st_mtime))
        file = next(folder / name for name in LEARNED if (folder / name).exists())
        found = json.loads(file.read_text(encoding="utf-8"))
        loop = ((name, found.get("loop", {}).get(name)) for name in GAINS)
        used = ((name, one) for name, one in loop if one and one["value"])
        gains = [f"{name} = {one['value']:.4g} {one['unit']}" for name, one in used]
        parts += [", ".join(found["sha256"]), ", ".join(gains) or "controller not known"]
    return " · ".join(parts)


class Workbench:
    """What all pages share: the folder, and the jobs."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.runs = folder, folder / "runs"
        self.jobs: dict[str, Job] = {}
        for mark in self.runs.glob(f"*{RUNNING}"):  # of jobs that did not end
            since, of = stamp(mark.stat().st_mtime), mark.read_text(encoding="utf-8")
            self.jobs[mark.stem] = Job(mark.stem, of, since, error=LOST, ended=True)
            mark.unlink()

    def files(self, suffixes: Iterable[str]) -> dict[str, str]:
        """Return the files of the folder and of folders in it by path, as shown."""
        found: dict[str, str] = {}
        for pattern in ("*", "*/*", "runs/*/*"):
            for path in sorted(self.folder.glob(pattern))[:MOST]:
                suffix = Path(path.name.lower().removesuffix(".gz")).suffix
                if suffix in suffixes and not path.name.startswith("."):
                    found[str(path)] = str(path.relative_to(self.folder))
        return found

    def logs(self) -> dict[str, str]:
        """Return the files that may be logs: of results those that have a description."""
        found, results = self.files(LOGS), set[Path]()
        for place in {Path(path).parent for path in found}:
            with suppress(OSError, ValueError, KeyError):
                names = json.loads((place / "manifest.json").read_text(encoding="utf-8"))["sha256"]
                results |= {place / name for name in names}
        described = {path for path in results if path.with_suffix(".toml") in results}
        return {path: name for path, name in found.items() if Path(path) not in results - described}

    def results(self) -> dict[str, str]:
        """Return the folders of results by name, the newest first, as shown."""
        found = {path.parent for name in LEARNED + PAGES for path in self.runs.glob(f"*/{name}")}
        newest = sorted(found, key=lambda one: -one.stat().st_mtime)
        return {one.name: titled(one) for one in newest}

    def begin(self, kind: str, of: list[str], task: Callable[..., Lines], **given: Any) -> Job:
        """Start a job on some files that writes to a new folder."""
        every = (f"{kind}-{Path(of[0]).stem}-{k}" for k in count(1))
        name = next(n for n in every if not (n in self.jobs or (self.runs / n).exists()))
        self.runs.mkdir(exist_ok=True)
        files, given["folder"] = ", ".join(Path(one).name for one in of), self.runs / name
        return self.jobs.setdefault(name, Job.begin(name, files, task, **given))

    def begun(self, kind: str) -> list[Job]:
        """Return the jobs of a kind that run, else the last one."""
        jobs = [job for name, job in self.jobs.items() if name.startswith(f"{kind}-")]
        return [job for job in jobs if not job.ended] or jobs[-1:]

    def close(self) -> None:
        """End the jobs."""
        for job in self.jobs.values():
            job.mark = None  # stays, for the next server
            job.stop()
