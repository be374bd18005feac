"""The protocol: every entrant is tuned on every drive, and validated there and on the others.

A cell is one entrant on one drive. Its result is kept as soon as it is known, so that an arena that
was interrupted goes on where it stopped, to the same bytes.
"""

import json
import shutil
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from stickslip import models
from stickslip.compensators.entrants import SPEED, Entrant, Part, entrant
from stickslip.compensators.names import content
from stickslip.fmi.errors import Fault
from stickslip.fmi.files import digest
from stickslip.fmi.process import temporary_folder
from stickslip.learned.writing import versions
from stickslip.storage.codec import encode
from stickslip.studies.arena import STARTS, TUNINGS, Budget
from stickslip.studies.arena.course import build_entrants
from stickslip.studies.arena.drives import Drive
from stickslip.studies.arena.motion_commands import COMMANDS
from stickslip.studies.arena.tuning import TuningResult, tune
from stickslip.studies.arena.validation import (
    RESOLUTION,
    ROBUSTNESS,
    ValidationResult,
    sensitivities,
    validate,
    validate_changed,
)
from stickslip.work.jobs import Execution, Outcome, ended_by_signals
from stickslip.work.kept_jobs import KeptJobs

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
        """Return an entrant by its name."""
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
    factor = drive.speed / SPEED
    tuned_by = [
        tune(cell.fmus, loop, one, plan.budget, seed + k, sheet, drive.speed)
        for k in range(plan.tunings if cell.entrant in content()["scattered"] else 1)
    ]
    found = min(tuned_by, key=lambda result: result.cost)
    document["footprint"] = _footprint(cell.fmus, one)
    tries = {drive.name: found}
    commands = [command.scaled(factor) for command in COMMANDS.values()]
    if cell.carried is not None:
        name, carried = cell.carried
        tries[name] = TuningResult.read(carried)
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


def _footprint(fmus: Path, one: Entrant) -> dict[str, float]:
    """Return numbers that it keeps between samples, if told, and bytes of its binaries here."""
    parts = [part for part in one.parts if part.compensator is not None]
    found = {"binary size": 0.0}
    for part in parts:
        with zipfile.ZipFile(fmus / f"{part.file}.fmu") as archive:
            members = archive.infolist()
        # The FMUs of the arena are built for the platform that runs them.
        binaries = [one.file_size for one in members if one.filename.startswith("binaries/")]
        found["binary size"] += max(binaries, default=0)
    if not any(part.own_fmu for part in parts):
        found["states"] = float(sum(len(part.kept) for part in parts))
    return found


def run_arena(
    plan: Plan,
    folder: Path,
    execution: Execution,
    # called with the number of cells that are done, that of all, and the last one
    on_done: Callable[[int, int, Cell], object] = lambda *_: None,
) -> Arena:
    """Run all cells; each is in ``unfinished/`` as soon as it is known."""
    jobs = KeptJobs("arena", "cells", folder, execution, plan.seed, "{}.json", _origin)
    # In the order of the plan, whichever cell is done first.
    places = [(drive.name, name) for drive in plan.drives for name in plan.entrants]

    def done(cell: Cell, _: Outcome) -> None:
        on_done(len(jobs.documents) + len(jobs.reasons), len(places), cell)

    with temporary_folder() as fmus:
        build(fmus, plan)
        for carries in (False, True):
            cells = _cells(plan, fmus, jobs.documents, carries=carries)
            jobs.run(run_cell, cells, len(places), done)

    def placed(found: Mapping[str, Any]) -> dict[tuple[str, str], Any]:
        return {place: found[_name(*place)] for place in places if _name(*place) in found}

    return Arena(plan, placed(jobs.documents), placed(jobs.reasons), jobs.kept)


def _name(drive: str, entrant: str) -> str:
    return f"{drive}/{entrant}"  # neither contains a slash


def _cells(
    plan: Plan, fmus: Path, documents: Mapping[str, Mapping[str, Any]], *, carries: bool
) -> list[Cell]:
    """Return the cells of the nominal drive, or those to which is carried over from there."""
    nominal, cells = plan.nominal or plan.drives[0], []
    for drive in plan.drives:
        for name in plan.entrants if (drive is not nominal) == carries else ():
            source = documents.get(_name(nominal.name, name)) if carries else None
            carried = (nominal.name, source["tuned"][nominal.name]) if source else None
            place = _name(drive.name, name)
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
    return {"origin": json.loads(json.dumps(origin))}
