"""What a reproduction is compared with: other drives, other assumptions, other motions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd

from stickslip import ga, models
from stickslip.evaluation.comparison import evaluate
from stickslip.evaluation.motion_study import study_motions
from stickslip.fmi.errors import Fault
from stickslip.identification.criteria.scaling import Scale
from stickslip.identification.estimation import Search
from stickslip.identification.stages import Identification
from stickslip.pipeline.datasheet_errors import vary_datasheet
from stickslip.pipeline.learned import Learned
from stickslip.pipeline.record_mode import learn_from_recording
from stickslip.pipeline.reproduction import Extras, Options, Progress, Reproduction, reproduce
from stickslip.pipeline.steps import TRAPEZOID, steps, with_steps
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.datasheet import LOOP, Datasheet
from stickslip.servo.paper_commands import TRAINING
from stickslip.tuning.coarse_start import coarsened, draw_factors
from stickslip.tuning.execution import Execution
from stickslip.tuning.learning import Study
from stickslip.tuning.published import study_as_published
from stickslip.tuning.published.study import OnGeneration, side_by_side
from stickslip.tuning.refinement import refine

SEEDS_OF_READINGS = 1
"""How many seeds learn under each other reading of the paper, in a complete reproduction."""
SHARE_OF_DEFAULT = 10
"""From one of so many of the coarse starts the default learns, too."""


def with_studies(
    reproduction: Reproduction,
    fmus: Path,
    progress: Progress,
    execution: Execution,
) -> Reproduction:
    """Return a reproduction with what is compared with it.

    Parameters
    ----------
    fmus : folder of its FMUs
    execution : its checkpoint is left as it is
    """
    options, found = reproduction.options, reproduction.identification
    own = replace(execution, checkpoint=None, resume=False)
    extras = reproduce_with_extras(options, fmus / "extras", progress, own)
    progress.stage("varying what is known beforehand")
    beforehand = vary_datasheet(fmus, options.feed, execution.workers, law=options.law)
    rig = FmuRig(fmus, Datasheet(), LOOP.T_s, options.law)
    study = recorded = None
    coarse: list[dict[str, float]] = []
    if options.complete:
        seeds = range(options.seed, options.seed + options.published_seeds)
        study = study_as_published(
            rig,
            found,
            seeds,
            reading_seeds=SEEDS_OF_READINGS,
            feed=options.feed,
            workers=own.workers,
            on_stage=progress.stage,
        )
        coarse = _from_coarse_starts(rig, found, options, seeds, progress, own)
        recorded = _recorded(rig, options, progress, own)
    progress.stage("all motions")
    studied = replace(reproduction, extras=extras, beforehand=beforehand, published=study)
    return with_motions(studied, fmus, coarse, recorded)


def with_motions(
    reproduction: Reproduction,
    fmus: Path,
    coarse: Sequence[Mapping[str, float]] = (),
    recorded: Learned | None = None,
) -> Reproduction:
    """Return a reproduction with what each of its steps does in all motions.

    Parameters
    ----------
    fmus : folder of its FMUs
    coarse, recorded : see ``steps``
    """
    found, options = reproduction.identification, reproduction.options
    published = reproduction.published.published if reproduction.published else None
    entries = steps(found, reproduction.learned, published, coarse, recorded)
    rig = FmuRig(fmus, Datasheet(), LOOP.T_s, options.law)
    motions = study_motions(rig, entries, found.loop, reproduction.exact, options.feed)
    return replace(reproduction, motions=motions)


def _from_coarse_starts(
    rig: FmuRig,
    found: Identification,
    options: Options,
    seeds: Sequence[int],
    progress: Progress,
    execution: Execution,
) -> list[dict[str, float]]:
    """Return what the default learns from the coarse starts of some of the seeds."""
    v_cmd = TRAINING.sample(rig.samples(TRAINING.duration))
    some = seeds[: max(1, len(seeds) // SHARE_OF_DEFAULT)]
    progress.stage(f"the default from the coarse starts of {len(some)} seeds")

    def learned(seed: int, _: OnGeneration) -> dict[str, float]:
        start = coarsened(found.estimates, draw_factors(seed))
        study = Study(rig, found.loop, start, v_cmd, options.feed, seed=seed)
        return refine(study).values  # noqa: PD011 - parameters by name

    return side_by_side(learned, some, execution.workers)


def _recorded(rig: FmuRig, options: Options, progress: Progress, execution: Execution) -> Learned:
    """Return what one recording of the drive gives."""
    search = Search(options.preset, execution=execution)
    return learn_from_recording(rig, options.seed, search, progress.stage, progress.generation)


def all_effects() -> dict[str, float]:
    """Return every Boolean parameter of the drive, switched on."""
    variables = models.load_model("drive").variables
    return {v.name: True for v in variables if v.role == "parameter" and v.type == "boolean"}


def reproduce_with_extras(
    options: Options, fmus: Path, progress: Progress, execution: Execution
) -> Extras:
    """Take the steps on the drive with all effects on; ``fmus`` is made."""
    fmus.mkdir()
    stages = _Named(progress)
    options = replace(options, loop_seeds=0, truth={**options.truth, **all_effects()})
    try:
        found = reproduce(options, fmus, stages, execution)
        return Extras(found.validation, step_by_step(found, fmus, stages, execution))
    except ga.Interrupted:  # its message is that of a search without a checkpoint
        raise KeyboardInterrupt from None
    except Fault as fault:
        return Extras(None, reason=str(fault))


def step_by_step(
    found: Reproduction, fmus: Path, progress: Progress, execution: Execution
) -> pd.DataFrame:
    """Return Table 4 of a reproduction with a column for each step but coarse starts."""
    options = found.options
    rig = FmuRig(fmus, Datasheet(), LOOP.T_s, options.law)
    recorded = _recorded(rig, options, progress, execution) if options.complete else None
    entries = steps(found.identification, found.learned, recorded=recorded)
    table = evaluate(rig, entries, options.feed, [TRAPEZOID]).table()
    return with_steps(found.validation.table(), table)


@dataclass(frozen=True)
class _Named:
    """Tells stages with the drive that they are of."""

    progress: Progress

    def stage(self, name: str) -> None:
        self.progress.stage(f"all extras on: {name}")

    def generation(self, algorithm: ga.Optimiser, scale: Scale | None = None) -> None:
        self.progress.generation(algorithm, scale)
