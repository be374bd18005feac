"""A fleet study: drives learned in workers, and the folder in which what is learned is kept."""

import json
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from stickslip import ga
from stickslip.errors import StickslipError, UsageError
from stickslip.fmi.files import digest
from stickslip.identification.estimation import Search
from stickslip.learned.writing import SCHEMA, versions
from stickslip.logs import Description, load_description
from stickslip.output import SILENT, Factors, Progress
from stickslip.papers.lugre.record_mode import learn_from_recording
from stickslip.rigs.fmu import rig_of
from stickslip.storage import MANIFEST, UNFINISHED, complete, refuse_foreign, staged
from stickslip.storage.writing import read_kept, write_json
from stickslip.studies.fleet.table import Drive, LogSource
from stickslip.studies.learn.document import log_document, recording_document
from stickslip.studies.learn.log_learning import learn
from stickslip.work.jobs import (
    Execution,
    Job,
    OnStage,
    Outcome,
    ended_by_signals,
    run_jobs,
    stopped,
)


@dataclass(frozen=True)
class _Stages(Progress):
    """Tells the pool of workers that a drive is still wanted."""

    on_stage: OnStage

    def stage(self, name: str) -> None:
        self.on_stage(name)

    def generation(self, algorithm: ga.Optimiser, scale: Factors | None = None) -> None:  # noqa: ARG002
        self.on_stage("searching")


def learn_drive(drive: Drive, seed: int, on_stage: OnStage | None = None) -> Outcome:
    """Learn one drive. Whatever goes wrong is an outcome, too, and costs no other drive.

    The result does not depend on where this runs: sums of products are formed by one thread here,
    because their last digits depend on how many share the work.
    """
    threadpool_limits(limits=1, user_api="blas")
    try:
        with ended_by_signals():
            document = _document(drive, seed, _Stages(on_stage) if on_stage else SILENT)
    except Exception as error:  # noqa: BLE001 - a fleet outlives any fault of one drive
        return Outcome(reason=_reason(drive, error))
    return Outcome(learned=json.dumps(document))


def _document(drive: Drive, seed: int, progress: Progress) -> dict[str, Any]:
    """Return the content of learned.json, with what the checks found."""
    if isinstance(drive.source, LogSource):
        config = drive.source.config
        description = load_description(config) if config else Description()
        learned = learn(drive.source.log, description, seed=seed, progress=progress)
        document = log_document(learned)
    else:
        with rig_of(drive.source) as rig:
            learned = learn_from_recording(rig, seed, Search(), progress)
        document = recording_document(learned)
    return document | {"findings": [str(finding) for finding in learned.findings]}


def _reason(drive: Drive, error: Exception) -> str:
    """Return one line, with paths as the table has them."""
    text = " ".join(str(error).split())
    if isinstance(drive.source, LogSource):
        for column, path in (("log", drive.source.log), ("config", drive.source.config)):
            text = text.replace(str(path), drive.row[column]) if path else text
    expected = isinstance(error, StickslipError)
    return text if expected and text else f"{type(error).__name__}: {text}".rstrip(": ")


TABLE = "fleet.csv"


@dataclass(frozen=True)
class Fleet:
    """What became of all drives."""

    drives: Sequence[Drive]  # in the order of the table
    learned: dict[str, dict[str, Any]]  # content of learned.json by name
    reasons: dict[str, str]  # why a drive failed, by name
    kept: int  # how many were not learned again


def learn_fleet(
    drives: Sequence[Drive],
    folder: Path,
    *,
    seed: int = 0,  # the same for each drive
    execution: Execution | None = None,  # where, and whether to go on from what is in the folder
    # called for each drive when it is learned, or has failed
    on_done: Callable[[Drive, Outcome], object] = lambda _, __: None,
    job: Job = learn_drive,
) -> Fleet:
    """Learn all drives; each learned.json is in ``unfinished/`` as soon as it is known.

    Raises UsageError when the folder holds a study that did not end and is not to be resumed, or
    files of the user where this one would keep what it learns, or KeyboardInterrupt at Ctrl-C; it
    says what is kept.
    """
    execution = execution or Execution()
    unfinished = folder / UNFINISHED
    complete(unfinished)
    refuse_foreign(unfinished, [_learned(drive) for drive in drives])
    if not execution.resume and (unfinished / MANIFEST).exists():
        raise UsageError(
            f"{unfinished}: an earlier study did not end; continue with <resume>, delete it, "
            "or choose another <out>"
        )
    origins = {drive.name: _origin(drive) for drive in drives}
    learned: dict[str, dict[str, Any]] = {}
    reasons: dict[str, str] = {}
    if execution.resume:
        for drive in drives:
            files = (place / _learned(drive) for place in (unfinished, folder / "drives"))
            known = {"schema": SCHEMA, "fleet": origins[drive.name], "seed": seed}
            documents = (read_kept(file, known | {"versions": versions()}) for file in files)
            if document := next((d for d in documents if d is not None), None):
                learned[drive.name] = document
    kept = len(learned)

    def take(drive: Drive, outcome: Outcome) -> None:
        if outcome.learned:
            document = {**json.loads(outcome.learned), "fleet": origins[drive.name]}
            with staged(unfinished, {"name": drive.name}) as staging:
                write_json(document, staging / _learned(drive))
            learned[drive.name] = document
        else:
            reasons[drive.name] = outcome.reason
        on_done(drive, outcome)

    left = [drive for drive in drives if drive.name not in learned]
    try:
        run_jobs(job, left, seed, execution.where, workers=execution.workers, on_done=take)
    except (KeyboardInterrupt, ga.WorkersLost) as stop:
        done = f"{len(learned)} of {len(drives)} drives are learned and kept in {folder}"
        raise stopped(stop, done) from None
    return Fleet(drives, learned, reasons, kept)


def _learned(drive: Drive) -> str:
    return f"{drive.name}/learned.json"


def _origin(drive: Drive) -> dict[str, Any]:
    """Return what a result is the result of, beside seed and versions: row and files."""
    files: dict[str, str | None] = {}
    if isinstance(drive.source, LogSource):
        for column, path in (("log", drive.source.log), ("config", drive.source.config)):
            if path is not None:
                files[column] = None
                with suppress(OSError):  # the drive will fail, and say why
                    files[column] = digest(path)
    return {"row": dict(drive.row), "sha256": files}
