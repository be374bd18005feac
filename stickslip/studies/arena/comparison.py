"""The arena from Python: ``stickslip.arena``."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.axes import Axes

from stickslip.compensators.entrants import default_names, own_part
from stickslip.errors import UsageError
from stickslip.fmi.process import temporary_folder
from stickslip.keywords import named
from stickslip.storage import reserved
from stickslip.studies.arena import STARTS, TUNINGS, Budget
from stickslip.studies.arena.drive_names import require_drives
from stickslip.studies.arena.drives import default_drives, learned_drive, read_drives
from stickslip.studies.arena.page import draw_heat_map, maps_of
from stickslip.studies.arena.protocol import Arena, Plan, run_arena
from stickslip.studies.arena.table import ALL, arena_table, medians, ranking, relative_errors
from stickslip.studies.arena.writing import FILES, write_arena
from stickslip.work.jobs import Execution


def make_plan(
    compensators: Sequence[str] | None = None,
    drives: Path | str | Mapping[str, Mapping[str, Any]] | None = None,
    *,
    laws: Sequence[str] | None = None,
    learned: Sequence[Path | str] = (),
    only: Sequence[str] = (),
    own: Mapping[Path | str, Path | str | Mapping[str, Any]] | None = None,
    evaluations: int = Budget.evaluations,
    seconds: float = Budget.seconds,
    seeds: int = STARTS,
    seed: int = 0,
    tunings: int = TUNINGS,
) -> Plan:
    """Return what an arena compares; parameters are those of ``arena``."""
    found = [learned_drive(Path(path)) for path in learned]
    if drives is not None:
        found += read_drives(_path(drives), laws)
    elif not found:
        found = default_drives(laws)
    known = [drive.name for drive in found]
    require_drives(only, known)
    if len({name.lower() for name in known}) < len(known):
        raise UsageError(
            "<drive>: two drives have the same name, upper and lower case alike, of"
            f" {', '.join(known)}"
        )
    if not seconds > 0.0:
        raise UsageError(f"<seconds {seconds:g}>: expected a number above 0")
    for name, given, least in (
        ("evaluations", evaluations, 10),
        ("seeds", seeds, 1),
        ("seed", seed, 0),
        ("tunings", tunings, 1),
    ):
        if not (isinstance(given, int) and given >= least):
            raise UsageError(f"<{name} {given!r}>: expected a whole number, at least {least}")
    parts = tuple(own_part(Path(fmu), _path(ports)) for fmu, ports in (own or {}).items())
    names = [
        *(default_names() if compensators is None else compensators),
        *(part.name for part in parts),
    ]
    if not names:
        raise UsageError("compensators: expected one or more, got none")
    plan = Plan(
        [drive for drive in found if not only or drive.name in only],
        list(dict.fromkeys(names)),
        Budget(evaluations, seconds),
        seeds,
        seed,
        parts,
        tunings,
    )
    for name in plan.entrants:
        plan.entrant(name)
    return plan


def _path(given: Path | str | Mapping[str, Any]) -> Path | Mapping[str, Any]:
    return Path(given) if isinstance(given, str) else given


@dataclass(frozen=True)
class Comparison:
    """What an arena found."""

    arena: Arena  # every cell
    table: pd.DataFrame  # the rows of arena.csv.gz, see docs/arena.md

    def __repr__(self) -> str:
        return repr(self.ranking)

    @property
    def ranking(self) -> pd.DataFrame:
        """A row an entrant: mean and worst error over the drives, relative to the reference."""
        return ranking(self.table, self.arena.plan)

    def errors(self, command: str = ALL, *, carried: bool = False) -> pd.DataFrame:
        """Return the errors relative to the reference, a row an entrant, a column a drive.

        Parameters
        ----------
        command : one of docs/arena.md, or ``all`` for the geometric mean over them
        carried : whether each is tuned on the nominal drive instead of on the drive itself
        """
        return relative_errors(self.table, self.arena.plan, carried=carried, command=command)

    def sensitivity(self) -> pd.DataFrame:
        """Return the peak sensitivity Ms of each entrant as tuned on each drive."""
        rows = self.table[self.table["metric"] == "Ms"]
        return medians(rows[rows["tuned_on"] == rows["drive"]], self.arena.plan)

    def plot(self) -> list[Axes]:
        """Draw the errors as heat maps: tuned on each drive, and carried over to it.

        Returns
        -------
        the axes; one where there is only one drive
        """
        from matplotlib import pyplot as plt  # late, for workers that draw nothing

        plan = self.arena.plan
        maps = maps_of(plan, self.table)
        size = (1.6 + len(maps) * (1.2 + 0.9 * len(plan.drives)), 1.4 + 0.4 * len(plan.entrants))
        figure, grid = plt.subplots(
            1, len(maps), sharey=True, squeeze=False, figsize=size, layout="constrained"
        )
        for axes, (title, wide) in zip(grid[0], maps.items(), strict=True):
            draw_heat_map(axes, wide, title)
        figure.supxlabel(
            f"error relative to that of {plan.reference}, tuned on the same drive; below 1 is"
            " better",
            fontsize="medium",
        )
        return list(grid[0])

    def write(self, folder: Path | str) -> Path:
        """Write arena.csv.gz, arena.html with its figures, and the winners; return the folder.

        Raises UsageError, OSError when a file to be replaced is the user's, or cannot be written.
        """
        folder = Path(folder)
        with reserved(folder, FILES):
            write_arena(self.arena, self.table, folder)
        return folder


@named(make_plan)
def arena(
    compensators: Sequence[str] | None = None,
    drives: Path | str | Mapping[str, Mapping[str, Any]] | None = None,
    *,
    workers: int = 1,
    where: str | None = None,
    folder: Path | str | None = None,
    resume: bool = False,
    progress: Callable[[int, int, str], object] = lambda *_: None,
    **options: Any,
) -> Comparison:
    """Tune compensators on drives and compare them on other motions, as ``stickslip arena``.

    Parameters
    ----------
    compensators : names, such as ``pi``, ``static`` or ``lugre+ekbf``; all by default
    drives : a file, or name -> ``{"law": ..., "parameters": ..., "loop": ..., "nominal": ...}``,
        as in docs/arena.md; by default those of the command
    workers, where : how many, and ``threads``, ``processes`` (the default for more than one) or
        the address of a Dask scheduler; the result does not depend on it
    folder : in which the cells are kept while the arena runs; none by default
    resume : go on with the cells in the folder
    progress : called with how many cells are done, how many there are, and the last one's name
    laws, only : keep only drives with these laws, or of these names
    learned : files learned.json, each a drive
    own : FMU of a compensator -> how it is connected, a TOML file or its content
    evaluations, seconds : budget of each compensator on each drive: candidates, and motion [s]
    seeds : runs of each command
    seed : of the algorithm and of the coarse start values
    tunings : random seeds, from that one on, of entrants whose rank moves with the seed

    Raises
    ------
    UsageError
        When a law, a compensator or a drive is unknown.
    """
    if resume and folder is None:
        raise UsageError("<resume>: expected the folder in which the cells are kept")
    plan = make_plan(compensators, drives, **options)
    place = where or ("threads" if workers == 1 else "processes")
    with ExitStack() as stack:
        kept = Path(folder) if folder else stack.enter_context(temporary_folder())
        try:
            found = run_arena(
                plan,
                kept,
                Execution(workers, place, resume=resume),
                lambda done, of, cell: progress(done, of, cell.name),
            )
        except KeyboardInterrupt:
            if folder is None:
                raise KeyboardInterrupt("interrupted; without a folder nothing is kept") from None
            raise
    return Comparison(found, arena_table(found))
