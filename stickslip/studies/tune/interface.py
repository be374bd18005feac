"""Tuning from Python: ``stickslip.tune``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Unpack

from stickslip import cosim
from stickslip.cosim.signals.tables import Inputs
from stickslip.errors import UsageError
from stickslip.figures import Figure
from stickslip.keywords import RunOptions, named
from stickslip.learned.file import LearnedFile
from stickslip.output import SILENT, Progress
from stickslip.rigs.contract import Rig
from stickslip.studies.tune import MOTIONS
from stickslip.studies.tune.on_rig import tune_on_rig
from stickslip.studies.tune.run import EVALUATIONS, TunedDrive, TuneSettings, tune_drive
from stickslip.studies.tune.signal_cost import read_cost
from stickslip.sweeping import Optimum, optimise


@named(RunOptions)
def tune(
    system: cosim.System | cosim.Fmu | Path | str,
    ranges: Mapping[str, Sequence[float]] | None = None,
    cost: Figure | Path | str | None = None,
    rig: Rig | None = None,
    motions: int = MOTIONS,
    progress: Progress = SILENT,
    *,
    evaluations: int = EVALUATIONS,
    algorithm: str = "default",
    seed: int = 0,
    workers: int = 1,
    fixed: Sequence[str] = (),
    force_limit: float | None = None,
    inputs: Inputs | None = None,
    where: str = "threads",
    **options: Unpack[RunOptions],
) -> TunedDrive | Optimum:
    """Tune the loop of a learned drive, or parameters of any system of FMUs.

    Parameters
    ----------
    system : a learned.json, or a system, an FMU, FILE.fmu or FILE.ssp
    ranges : ``component.variable`` -> (lowest, highest), of a system also (lowest, start, highest);
        of a learned drive instead of or beside those that are searched by default
    cost : of a system: a cost file, or a function of the result that gives a number of 0 or more
    rig : the learned drive, which then runs the present loop, the tuned one and loops between them
    motions : of the rig, at most
    progress : is told of stages and generations
    evaluations : number of candidates
    algorithm, seed, workers : as of ``optimise``
    fixed : of a learned drive: parameters, or components such as ``controller``, that stay
    force_limit : of a learned drive: that of the motor [N]; by default the one of the file
    inputs, where, start, stop, step, record and all others : of a system: as of ``optimise``

    Raises
    ------
    UsageError
        When the file, a range, a name or the cost is not valid, or a keyword is of the other kind.
    GaError
        When no candidate can be run.
    CosimError
        When the system, a name or an input is wrong.
    RigError
        When a motion of the rig did not end as commanded; LimitError, which is one, when a limit
        ended one of the present loop.
    """
    budget: dict[str, Any] = {"evaluations": evaluations, "algorithm": algorithm}
    budget |= {"seed": seed, "workers": workers}
    if isinstance(system, Path | str) and Path(system).suffix == ".json":
        try:
            spans = {
                name: (float(low), float(high)) for name, (low, high) in (ranges or {}).items()
            }
        except (TypeError, ValueError):
            raise UsageError(f"ranges: expected (lowest, highest) of each, got {ranges}") from None
        of_system = {**options, "cost": cost, "inputs": inputs, "where": where != "threads"}
        if given := [name for name, value in of_system.items() if value]:
            raise UsageError(f"{system}: {given[0]} is of a system, and this is a learned drive")
        learned = LearnedFile(Path(system))
        settings = TuneSettings(spans, tuple(fixed), force_limit, **budget)
        if rig is not None:
            return tune_on_rig(rig, learned, settings, motions, progress=progress)
        return tune_drive(learned, settings, progress)
    of_drive = {"rig": rig, "fixed": fixed, "force_limit": force_limit}
    if given := [name for name, value in of_drive.items() if value]:
        raise UsageError(f"{given[0]} is of a learned drive; expected a learned.json of it")
    if not callable(cost):
        if cost is None or not ranges:
            raise UsageError("a system is tuned with ranges and a cost")
        cost = read_cost(Path(cost))
        options.setdefault("record", cost.record)
    budget |= {"inputs": inputs, "where": where, "progress": progress, **options}
    return optimise(system, ranges or {}, cost, **budget)
