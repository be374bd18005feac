"""What a reproduction is compared with: other drives, other assumptions, other motions."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import ga
from stickslip.beforehand import vary_datasheet
from stickslip.evaluation import Entry
from stickslip.execution import Execution
from stickslip.extras import Extras, all_effects
from stickslip.motion_study import IDENTIFIED, LEARNED, UNCOMPENSATED, study_motions
from stickslip.parameters import LUGRE
from stickslip.reproduction import Options, Progress, Reproduction, reproduce
from stickslip.rig import Rig
from stickslip.setup import LOOP, Datasheet
from toolchain import Fault


def with_studies(
    reproduction: Reproduction, fmus: Path, progress: Progress, execution: Execution
) -> Reproduction:
    """Return a reproduction with what is compared with it.

    Parameters
    ----------
    fmus : folder of its FMUs
    execution : its checkpoint is left as it is
    """
    options = reproduction.options
    extras = reproduce_with_extras(options, fmus / "extras", progress, execution)
    progress.stage("varying what is known beforehand")
    beforehand = vary_datasheet(fmus, options.feed, execution.workers)
    progress.stage("slow motions")
    return with_motions(replace(reproduction, extras=extras, beforehand=beforehand), fmus)


def with_motions(reproduction: Reproduction, fmus: Path) -> Reproduction:
    """Return a reproduction with what its compensators do in slow and short motions.

    Parameters
    ----------
    fmus : folder of its FMUs
    """
    found = reproduction.identification
    entries = {
        UNCOMPENSATED: Entry(found.loop),
        IDENTIFIED: Entry(found.loop, {name: found.estimates[name].value for name in LUGRE}),
        LEARNED: Entry(found.loop, reproduction.learned.values),
    }
    rig = Rig(fmus, Datasheet(), LOOP.T_s)
    options, truth = reproduction.options, reproduction.truth
    motions = study_motions(rig, entries, found.loop, truth, options.feed)
    return replace(reproduction, motions=motions)


def reproduce_with_extras(
    options: Options, fmus: Path, progress: Progress, execution: Execution
) -> Extras:
    """Identify, learn and validate on the drive with all effects on; ``fmus`` is made."""
    fmus.mkdir()
    try:
        found = reproduce(
            replace(options, truth={**options.truth, **all_effects()}),
            fmus,
            _Named(progress),
            replace(execution, checkpoint=None, resume=False),
        )
    except ga.Interrupted:  # its message is that of a search without a checkpoint
        raise KeyboardInterrupt from None
    except Fault as fault:
        return Extras(None, str(fault))
    return Extras(found.validation)


@dataclass(frozen=True)
class _Named:
    """Tells stages with the drive that they are of."""

    progress: Progress

    def stage(self, name: str) -> None:
        self.progress.stage(f"all extras on: {name}")

    def generation(self, algorithm: ga.Optimiser) -> None:
        self.progress.generation(algorithm)
