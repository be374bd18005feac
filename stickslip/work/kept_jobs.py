"""Jobs whose results are kept one by one, so that a study that was interrupted goes on."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from stickslip import ga
from stickslip.errors import UsageError
from stickslip.fmi.files import MOST_TEXT, parse_json, read_limited
from stickslip.storage import MANIFEST, UNFINISHED, complete, refuse_foreign, staged
from stickslip.storage.writing import write_json
from stickslip.work.jobs import Execution, Job, Outcome, run_jobs, stopped


@dataclass
class KeptJobs:
    """Jobs on named items; each result is in ``unfinished/`` of a folder as soon as it is known.

    Raises UsageError when the folder holds a study that did not end and is not to be resumed.
    """

    study: str  # display name
    items: str  # display name of the items, in the plural
    folder: Path
    execution: Execution
    seed: int
    file: str  # of a result, with {} in the place of the item's name
    origin: Callable[[Any], Mapping[str, Any]]  # entries that say what a result is the result of
    own: Mapping[str, Any] = field(default_factory=dict)  # such entries that a job writes itself
    finished: str = ""  # folder of results that ended, from which a resumed study also takes
    documents: dict[str, dict[str, Any]] = field(default_factory=dict)  # results by name
    reasons: dict[str, str] = field(default_factory=dict)  # why an item has none, by name
    kept: int = 0  # how many were known before

    def __post_init__(self) -> None:
        self._unfinished = self.folder / UNFINISHED
        complete(self._unfinished)
        if not self.execution.resume and (self._unfinished / MANIFEST).exists():
            raise UsageError(
                f"{self._unfinished}: an earlier {self.study} did not end; continue with <resume>, "
                "delete it, or choose another <out>"
            )

    def run(
        self,
        job: Job,
        items: Sequence[Any],
        total: int,  # of all items, these and others
        on_done: Callable[[Any, Outcome], object],
    ) -> None:
        """Do the jobs whose results are not known yet; raise UsageError or KeyboardInterrupt."""
        refuse_foreign(self._unfinished, [self.file.format(item.name) for item in items])
        origins = {item.name: self.origin(item) for item in items}
        places = [self._unfinished, *([self.folder / self.finished] if self.finished else [])]
        for name, origin in origins.items() if self.execution.resume else ():
            expected = {**self.own, **origin}
            found = (_read(place / self.file.format(name), expected) for place in places)
            if document := next(filter(None, found), None):
                self.documents[name] = document
                self.kept += 1

        def take(item: Any, outcome: Outcome) -> None:
            name = item.name
            if outcome.learned:
                self.documents[name] = json.loads(outcome.learned) | origins[name]
                with staged(self._unfinished, {"name": name}) as staging:
                    write_json(self.documents[name], staging / self.file.format(name))
            else:
                self.reasons[name] = outcome.reason
            on_done(item, outcome)

        left = [item for item in items if item.name not in self.documents]
        execution = self.execution
        try:
            run_jobs(job, left, self.seed, execution.where, workers=execution.workers, on_done=take)
        except (KeyboardInterrupt, ga.WorkersLost) as stop:
            done = f"{len(self.documents)} of {total} {self.items} are kept in {self.folder}"
            raise stopped(stop, done) from None


def _read(path: Path, expected: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return the document of an earlier run, None unless it has the expected entries."""
    try:
        document = parse_json(read_limited(path, MOST_TEXT))
    except (OSError, ValueError):
        return None
    known = isinstance(document, dict) and expected.items() <= document.items()
    return document if known else None
