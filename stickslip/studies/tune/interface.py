"""Tuning from Python: ``stickslip.tune``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from stickslip import cosim
from stickslip.errors import UsageError
from stickslip.figures import Figure
from stickslip.learned.file import LearnedFile
from stickslip.output import SILENT, Progress
from stickslip.rigs.contract import Rig
from stickslip.studies.tune import MOTIONS
from stickslip.studies.tune.on_rig import tune_on_rig
from stickslip.studies.tune.run import TunedDrive, TuneSettings, tune_drive
from stickslip.studies.tune.signal_cost import read_cost
from stickslip.sweeping import Optimum, optimise


def tune(
    system: cosim.System | cosim.Fmu | Path | str,
    ranges: Mapping[str, Sequence[float]] | None = None,
    cost: Figure | Path | str | None = None,
    rig: Rig | None = None,
    motions: int = MOTIONS,
    progress: Progress = SILENT,
    **options: Any,
) -> TunedDrive | Optimum:
    """Tune the loop of a learned drive, or parameters of any system of FMUs.

    Parameters
    ----------
    system : a learned.json, or a system, an FMU, FILE.fmu or FILE.ssp
    ranges : ``component.variable`` -> (lowest, highest); of a learned drive instead of or beside
        those that are searched by default
    cost : of a system: a cost file, or a function of the result that gives a number of 0 or more
    rig : the learned drive, which then runs the present loop, the tuned one and loops between them
    motions : of the rig, at most
    progress : is told of stages and generations
    options : ``evaluations``, ``algorithm``, ``seed`` and ``workers``; of a learned drive those of
        ``TuneSettings``, of a system those of ``optimise``

    Raises
    ------
    UsageError
        When the file, a range, a name or the cost is not valid.
    GaError
        When no candidate can be run.
    CosimError
        When the system, a name or an input is wrong.
    RigError
        When a motion of the rig did not end as commanded; LimitError, which is one, when a limit
        ended one of the present loop.
    """
    if isinstance(system, Path | str) and Path(system).suffix == ".json":
        try:
            spans = {
                name: (float(low), float(high)) for name, (low, high) in (ranges or {}).items()
            }
        except (TypeError, ValueError):
            raise UsageError(f"ranges: expected (lowest, highest) of each, got {ranges}") from None
        learned, settings = LearnedFile(Path(system)), TuneSettings(spans, **options)
        if rig is not None:
            return tune_on_rig(rig, learned, settings, motions, progress=progress)
        return tune_drive(learned, settings, progress)
    if rig is not None:
        raise UsageError("a rig tunes a learned drive; expected a learned.json of it")
    if not callable(cost):
        if cost is None or not ranges:
            raise UsageError("a system is tuned with ranges and a cost")
        cost = read_cost(Path(cost))
        options.setdefault("record", cost.record)
    return optimise(system, ranges or {}, cost, progress=progress, **options)
