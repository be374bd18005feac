"""The protocol: every entrant is tuned on every drive, and validated there and on the others.

A cell is one entrant on one drive. Its result is kept as soon as it is known, so that an arena that
was interrupted goes on where it stopped, to the same bytes.
"""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from stickslip import ga, models
from stickslip.compensators.entrants import SPEED, Entrant, Part, entrant
from stickslip.compensators.names import content
from stickslip.errors import UsageError
from stickslip.fmi.errors import Fault
from stickslip.fmi.files import atomic_write, digest
from stickslip.fmi.process import temporary_folder
from stickslip.learned.writing import versions
from stickslip.storage import MANIFEST, UNFINISHED, complete, staged
from stickslip.storage.codec import decode, encode
from stickslip.storage.writing import read_kept
from stickslip.studies.arena.budget import STARTS, TUNINGS, Budget
from stickslip.studies.arena.course import build_entrants
from stickslip.studies.arena.drives import Drive
from stickslip.studies.arena.motion_commands import COMMANDS
from stickslip.studies.arena.running import footprint, seconds_per_step
from stickslip.studies.arena.tuning import TuningResult, tune
from stickslip.studies.arena.validation import (
    RESOLUTION,
    ROBUSTNESS,
    ValidationResult,
    sensitivities,
    validate,
    validate_changed,
)
from stickslip.work.jobs import Execution, Outcome, ended_by_signals, run_jobs, stopped

REFERENCES = ("pi", "none")  # Entrants to which errors are relative, the preferred one first


@dataclass(frozen=True)
class Plan:
    """What an arena compares."""

    drives: Sequence[Drive]  # the one whose ``nominal`` is set gives what is carried over
    entrants: Sequence[str]  # names
    budget: Budget = field(default_factory=Budget)
    starts: int = STARTS  # runs of each command
    seed: int = 0  # of tuning and of coarse start values
    own: tuple[Part, ...] = ()  # compensators of the user
    tunings: int = TUNINGS  # random seeds of entrants whose rank moves with the seed

    def entrant(self, name: str) -> Entrant:
        """Return an entrant by its name.

        Raises UsageError when one of its parts is unknown, or cannot follow the one before it.
        """
        return entrant(name, {part.name: part for part in self.own})

    @property
    def reference(self) -> str:
        """The entrant to which errors are relative: the tuned PI controller where it competes."""
        return next((name for name in REFERENCES if name in self.entrants), self.entrants[0])

    @property
    def nominal(self) -> Drive | None:
        """The drive on which what is carried over was tuned; None where there is only one."""
        if len(self.drives) < 2:
            return None
        return next((drive for drive in self.drives if drive.nominal), self.drives[0])


@dataclass(frozen=True)
class Cell:
    """One entrant on one drive, as a job."""

    name: str
    fmus: Path  # folder of the FMUs of the drive and of all entrants
    drive: Drive
    entrant: str
    plan: Plan
    # what was tuned on the nominal drive, a document of ``TuningResult``; None for none
    carried: tuple[str, Mapping[str, Any]] | None = None


@dataclass(frozen=True)
class Arena:
    """All cells."""

    plan: Plan
    # of the cells that have a result, by (drive, entrant)
    documents: Mapping[tuple[str, str], Mapping[str, Any]]
    reasons: Mapping[tuple[str, str], str]  # why the others have none
    kept: int


def run_cell(cell: Cell, seed: int, on_stage: Callable[[str], object] | None = None) -> Outcome:
    """Tune and validate an entrant on a drive; whatever goes wrong is an outcome, too."""
    threadpool_limits(limits=1, user_api="blas")
    try:
        with ended_by_signals():
            if on_stage is not None:
                on_stage(cell.name)
            return Outcome(json.dumps(_document(cell, seed)))
    except Fault as error:
        return Outcome(reason=" ".join(str(error).split()))


def _document(cell: Cell, seed: int) -> dict[str, Any]:
    plan, drive = cell.plan, cell.drive
    one, sheet, loop = plan.entrant(cell.entrant), drive.sheet, drive.loop
    document: dict[str, Any] = {"tuned": {}, "validated": {}}
    begun, factor = time.thread_time(), drive.speed / SPEED
    tuned_by = [
        tune(cell.fmus, loop, one, plan.budget, seed + k, sheet, drive.speed)
        for k in range(plan.tunings if cell.entrant in content()["scattered"] else 1)
    ]
    found = min(tuned_by, key=lambda result: result.cost)
    # What a clock shows is no result: it differs from run to run.
    document["time"] = {"tuning": time.thread_time() - begun}
    measured = found.tuned(one, loop, sheet), found.coarse.friction
    document["time"] |= seconds_per_step(cell.fmus, loop, one, *measured)
    document["footprint"] = footprint(cell.fmus, one)
    tries = {drive.name: found}
    commands = [command.scaled(factor) for command in COMMANDS.values()]
    if cell.carried is not None:
        name, carried = cell.carried
        tries[name] = decode(TuningResult, carried)
    for name, given in tries.items():
        document["tuned"][name] = encode(given)
        try:
            tuned = given.tuned(one, loop, sheet)
            peaks = sensitivities(cell.fmus, loop, one, tuned, given.coarse.friction, drive.mass)
            others = [result for result in tuned_by if name == drive.name and result is not given]
            starts = -(-plan.starts // (1 + len(others)))
            found_there = validate(cell.fmus, loop, one, tuned, commands, starts, sheet)
            for other in others:  # all count alike
                also = other.tuned(one, loop, sheet)
                found_there.add(validate(cell.fmus, loop, one, also, commands, starts, sheet))
            if name == drive.name:
                changes = drive.changes(ROBUSTNESS, RESOLUTION)
                how = changes, plan.starts, sheet, factor
                found_there.figures |= validate_changed(cell.fmus, loop, one, tuned, *how)
        except Fault as error:
            if name == drive.name:
                raise
            found_there, peaks = ValidationResult(reason=" ".join(str(error).split())), {}
        # JSON has no infinite numbers; the loop is unstable where a peak is missing.
        finite = {key: peak for key, peak in peaks.items() if np.isfinite(peak)}
        document["validated"][name] = {**found_there.document(), "peaks": finite}
    return document


def run_arena(
    plan: Plan,
    folder: Path,
    execution: Execution,
    # called with the number of cells that are done, that of all, and the last one
    on_done: Callable[[int, int, Cell], object] = lambda *_: None,
) -> Arena:
    """Run all cells; each is in ``unfinished/`` as soon as it is known.

    Raises UsageError when the folder holds an arena that did not end and is not to be resumed, or
    KeyboardInterrupt at Ctrl-C; it says what is kept.
    """
    unfinished = folder / UNFINISHED
    complete(unfinished)
    if not execution.resume and (unfinished / MANIFEST).exists():
        raise UsageError(
            f"{unfinished}: an earlier arena did not end; continue with --resume, delete it, or"
            " choose another <out>"
        )
    documents: dict[tuple[str, str], Mapping[str, Any]] = {}
    reasons: dict[tuple[str, str], str] = {}
    total = len(plan.drives) * len(plan.entrants)
    with temporary_folder() as fmus:
        build(fmus, plan)
        kept = 0
        for carries in (False, True):
            cells = _cells(plan, fmus, documents, carries=carries)
            for cell in cells if execution.resume else ():
                path, origin = unfinished / f"{cell.name}.json", {"origin": _origin(cell)}
                if (known := read_kept(path, origin)) is not None:
                    documents[cell.drive.name, cell.entrant] = known
                    kept += 1
            left = [cell for cell in cells if (cell.drive.name, cell.entrant) not in documents]

            def take(cell: Cell, outcome: Outcome) -> None:
                place = cell.drive.name, cell.entrant
                if outcome.learned:
                    documents[place] = _keep(unfinished, cell, outcome.learned)
                else:
                    reasons[place] = outcome.reason
                on_done(len(documents) + len(reasons), total, cell)

            try:
                run_jobs(run_cell, left, plan.seed, execution.where, execution.workers, take)
            except (KeyboardInterrupt, ga.WorkersLost) as stop:
                done = f"{len(documents)} of {total} cells are kept in {folder}"
                raise stopped(stop, done) from None
    # In the order of the plan, whichever cell was done first.
    order = [(drive.name, name) for drive in plan.drives for name in plan.entrants]
    return Arena(
        plan,
        {place: documents[place] for place in order if place in documents},
        {place: reasons[place] for place in order if place in reasons},
        kept,
    )


def _cells(
    plan: Plan,
    fmus: Path,
    documents: Mapping[tuple[str, str], Mapping[str, Any]],
    *,
    carries: bool,
) -> list[Cell]:
    """Return the cells of the nominal drive, or those to which is carried over from there."""
    nominal, cells = plan.nominal or plan.drives[0], []
    for drive in plan.drives:
        for name in plan.entrants if (drive is not nominal) == carries else ():
            source = documents.get((nominal.name, name)) if carries else None
            carried = (nominal.name, source["tuned"][nominal.name]) if source else None
            place = f"{drive.name}-{name}"
            cells.append(Cell(place, fmus / drive.name, drive, name, plan, carried))
    return cells


def build(folder: Path, plan: Plan) -> None:
    """Build a folder of FMUs for each drive; only the drive FMU has its true parameters."""
    common = folder / ".entrants"  # the name of no drive
    build_entrants(common, [plan.entrant(name) for name in ("none", *plan.entrants)])
    for drive in plan.drives:
        own = folder / drive.name
        models.build_fmu("drive", own, start=drive.parameters, law=drive.law)
        for file in sorted(common.iterdir()):
            shutil.copy(file, own)
        models.build_fmu("velocity_controller", own, start={"u_max": drive.sheet.peak_force})


def _origin(cell: Cell) -> dict[str, Any]:
    """Return what a result is the result of."""
    plan = cell.plan
    origin = {
        "drive": asdict(cell.drive),
        "entrant": cell.entrant,
        "budget": asdict(plan.budget),
        "starts": plan.starts,
        "seed": plan.seed,
        "tunings": plan.tunings,
        "carried": cell.carried,
        "own": {part.name: [digest(part.own_fmu), repr(part)] for part in plan.own if part.own_fmu},
        "versions": versions(),
    }
    plain: dict[str, Any] = json.loads(json.dumps(origin))
    return plain


def _keep(unfinished: Path, cell: Cell, text: str) -> Mapping[str, Any]:
    document: dict[str, Any] = {**json.loads(text), "origin": _origin(cell)}
    with staged(unfinished, {"name": cell.name}) as staging:
        atomic_write(staging / f"{cell.name}.json", json.dumps(document) + "\n")
    return document
