"""The protocol: every entrant is tuned on every drive, and validated there and on the others.

A cell is one entrant on one drive. Its result is kept as soon as it is known, so that an arena that
was interrupted goes on where it stopped, to the same bytes.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from stickslip import models
from stickslip.errors import UsageError
from stickslip.evaluation.arena.commands import COMMANDS
from stickslip.evaluation.arena.course import build_entrants
from stickslip.evaluation.arena.drives import Drive
from stickslip.evaluation.arena.entrants import SPEED, Coarse, Entrant, Part, entrant
from stickslip.evaluation.arena.tuning import Budget, Found, tune
from stickslip.evaluation.arena.validation import sensitivities, validate
from stickslip.fmi.errors import Fault
from stickslip.fmi.files import MOST_TEXT, atomic_write, digest, parse_json, read_limited
from stickslip.fmi.process import temporary_folder
from stickslip.results.folder import MANIFEST, complete, staged
from stickslip.results.learned import versions
from stickslip.tuning.execution import Execution
from stickslip.tuning.jobs import Outcome, ended_by_signals, run_jobs

UNFINISHED = "unfinished"
"""The folder of what is known while an arena runs."""


@dataclass(frozen=True)
class Plan:
    """What an arena compares.

    Attributes
    ----------
    drives : the one whose ``nominal`` is set gives what is carried over
    entrants : names
    starts : runs of each command
    seed : of tuning and of coarse start values
    own : compensators of the user
    """

    drives: Sequence[Drive]
    entrants: Sequence[str]
    budget: Budget = field(default_factory=Budget)
    starts: int = 20
    seed: int = 0
    own: tuple[Part, ...] = ()

    def entrant(self, name: str) -> Entrant:
        """Return an entrant by its name.

        Raises
        ------
        UsageError
            When one of its parts is unknown, or cannot follow the one before it.
        """
        return entrant(name, {part.name: part for part in self.own})

    @property
    def nominal(self) -> Drive | None:
        """The drive on which what is carried over was tuned; None where there is only one."""
        if len(self.drives) < 2:
            return None
        return next((drive for drive in self.drives if drive.nominal), self.drives[0])


@dataclass(frozen=True)
class Cell:
    """One entrant on one drive, as a job.

    Attributes
    ----------
    fmus : folder of the FMUs of the drive and of all entrants
    carried : what was tuned on the nominal drive, a document of ``Found``; None for none
    """

    name: str
    fmus: Path
    drive: Drive
    entrant: str
    plan: Plan
    carried: tuple[str, Mapping[str, Any]] | None = None


@dataclass(frozen=True)
class Arena:
    """All cells.

    Attributes
    ----------
    documents : of the cells that have a result, by (drive, entrant)
    reasons : why the others have none
    """

    plan: Plan
    documents: Mapping[tuple[str, str], Mapping[str, Any]]
    reasons: Mapping[tuple[str, str], str]
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
    found = tune(cell.fmus, loop, one, plan.budget, seed, sheet, drive.speed)
    tries = {drive.name: found}
    commands = [command.scaled(drive.speed / SPEED) for command in COMMANDS.values()]
    if cell.carried is not None:
        name, carried = cell.carried
        tries[name] = found_of(carried)
    for name, given in tries.items():
        tuned = given.tuned(one, loop, sheet)
        friction = given.coarse.friction
        peaks = sensitivities(cell.fmus, loop, one, tuned, friction, drive.mass)
        validated = validate(cell.fmus, loop, one, tuned, commands, plan.starts, sheet).document()
        document["tuned"][name] = asdict(given)
        document["validated"][name] = {**validated, "peaks": peaks}
    return document


def found_of(document: Mapping[str, Any]) -> Found:
    """Return what was tuned, from its document."""
    return Found(**{**document, "coarse": Coarse(**document["coarse"])})


def run_arena(
    plan: Plan,
    folder: Path,
    execution: Execution,
    on_done: Callable[[int, int, str], object] = lambda *_: None,
) -> Arena:
    """Run all cells; each is in ``unfinished/`` as soon as it is known.

    Parameters
    ----------
    on_done : called with the number of cells that are done, that of all, and the last one's name

    Raises
    ------
    UsageError
        When the folder holds an arena that did not end and is not to be resumed.
    KeyboardInterrupt
        At Ctrl-C; says what is kept.
    """
    unfinished = folder / UNFINISHED
    complete(unfinished)
    if not execution.resume and (unfinished / MANIFEST).exists():
        raise UsageError(
            f"{unfinished}: an earlier arena did not end; continue with --resume, delete it, or"
            " choose another folder with --out"
        )
    documents: dict[tuple[str, str], Mapping[str, Any]] = {}
    reasons: dict[tuple[str, str], str] = {}
    total = len(plan.drives) * len(plan.entrants)
    with temporary_folder() as fmus:
        build(fmus, plan)
        nominal = plan.nominal
        first = [drive for drive in plan.drives if nominal is None or drive is nominal]
        rest = [drive for drive in plan.drives if drive not in first]
        kept = 0
        for drives in (first, rest):
            cells = []
            for drive in drives:
                for name in plan.entrants:
                    cell = Cell(f"{drive.name}-{name}", fmus / drive.name, drive, name, plan)
                    if nominal is not None and drive is not nominal:
                        source = documents.get((nominal.name, name))
                        if source is not None:
                            tuned = source["tuned"][nominal.name]
                            cell = replace(cell, carried=(nominal.name, tuned))
                    known = _kept(unfinished, cell) if execution.resume else None
                    if known is None:
                        cells.append(cell)
                    else:
                        kept += 1
                        documents[drive.name, name] = known

            def take(cell: Cell, outcome: Outcome) -> None:
                place = cell.drive.name, cell.entrant
                if outcome.learned:
                    documents[place] = _keep(unfinished, cell, outcome.learned)
                else:
                    reasons[place] = outcome.reason
                on_done(len(documents) + len(reasons), total, cell.name)

            try:
                run_jobs(run_cell, cells, plan.seed, execution.where, execution.workers, take)
            except KeyboardInterrupt:
                raise KeyboardInterrupt(
                    f"interrupted; {len(documents)} of {total} cells are kept in {folder};"
                    " continue with --resume"
                ) from None
    return Arena(plan, documents, reasons, kept)


def build(folder: Path, plan: Plan) -> None:
    """Build a folder of FMUs for each drive; only the drive FMU has its true parameters."""
    common = folder / "entrants"
    build_entrants(common, [plan.entrant(name) for name in ("none", *plan.entrants)])
    for drive in plan.drives:
        own = folder / drive.name
        models.build_fmu("drive", own, start=drive.parameters, law=drive.law)
        for file in sorted(common.iterdir()):
            shutil.copy(file, own)


def _origin(cell: Cell) -> dict[str, Any]:
    """Return what a result is the result of."""
    plan = cell.plan
    origin = {
        "drive": asdict(cell.drive),
        "entrant": cell.entrant,
        "budget": asdict(plan.budget),
        "starts": plan.starts,
        "seed": plan.seed,
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


def _kept(unfinished: Path, cell: Cell) -> Mapping[str, Any] | None:
    """Return an earlier result of a cell, if it is the one that would be found now."""
    try:
        document = parse_json(read_limited(unfinished / f"{cell.name}.json", MOST_TEXT))
    except (OSError, ValueError):
        return None
    if not isinstance(document, dict) or document.get("origin") != _origin(cell):
        return None
    return document
