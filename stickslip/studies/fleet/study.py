"""A fleet study: drives learned in workers, and the folder in which what is learned is kept."""

import json
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from stickslip import ga
from stickslip.errors import StickslipError
from stickslip.fmi.files import digest
from stickslip.learned.writing import SCHEMA, versions
from stickslip.logs import Description, load_description
from stickslip.output import SILENT, Factors, Progress
from stickslip.studies.fleet.table import Drive
from stickslip.studies.learn.document import log_document
from stickslip.studies.learn.log_learning import learn
from stickslip.work.jobs import Execution, Job, OnStage, Outcome, ended_by_signals
from stickslip.work.kept_jobs import KeptJobs


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
            config, progress = drive.files.get("config"), _Stages(on_stage) if on_stage else SILENT
            description = load_description(config) if config else Description()
            learned = learn(drive.files["log"], description, seed=seed, progress=progress)
            document = log_document(learned) | {"findings": [*map(str, learned.findings)]}
    except Exception as error:  # noqa: BLE001 - a fleet outlives any fault of one drive
        return Outcome(reason=_reason(drive, error))
    return Outcome(learned=json.dumps(document))


def _reason(drive: Drive, error: Exception) -> str:
    """Return one line, with paths as the table has them."""
    text = " ".join(str(error).split())
    for column, path in drive.files.items():
        text = text.replace(str(path), drive.row[column])
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
    """Learn all drives; each learned.json is in ``unfinished/`` as soon as it is known."""
    jobs = KeptJobs(
        "study",
        "drives",
        folder,
        execution or Execution(),
        seed=seed,
        file="{}/learned.json",
        origin=_origin,
        own={"schema": SCHEMA, "seed": seed, "versions": versions()},
        finished="drives",
    )
    jobs.run(job, drives, len(drives), on_done)
    return Fleet(drives, jobs.documents, jobs.reasons, jobs.kept)


def _origin(drive: Drive) -> dict[str, Any]:
    """Return what a result is the result of, beside seed and versions: row and files."""
    files: dict[str, str | None] = dict.fromkeys(drive.files)
    for column, path in drive.files.items():
        with suppress(OSError):  # the drive will fail, and say why
            files[column] = digest(path)
    return {"fleet": {"row": dict(drive.row), "sha256": files}}
