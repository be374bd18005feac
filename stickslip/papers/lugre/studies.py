"""What a reproduction is compared with: a drive with all effects, other motions and learning."""

from dataclasses import replace
from pathlib import Path

import pandas as pd

from stickslip import models
from stickslip.evaluation.comparison import evaluate
from stickslip.evaluation.validation import PHASES
from stickslip.fmi.errors import Fault
from stickslip.identification.estimation import Search
from stickslip.output import Progress
from stickslip.papers.lugre.published import OURS, SQUARES, study_as_published
from stickslip.papers.lugre.record import learn_from_recording
from stickslip.papers.lugre.reproduction import Extras, Options, Reproduction, reproduce
from stickslip.papers.lugre.steps import TRAPEZOID, steps, with_steps
from stickslip.studies.learn.learned import Learned


def with_studies(
    reproduction: Reproduction,
    fmus: Path,  # folder of its FMUs
    progress: Progress,
    workers: int,
) -> Reproduction:
    """Return a reproduction with what is compared with it."""
    options, found = reproduction.options, reproduction.identification
    extras = reproduce_with_extras(options, fmus / "extras", progress)
    rig = options.rig(fmus)
    study = recorded = None
    if options.complete:
        study = study_as_published(
            rig, found, options.all_seeds, workers=workers, on_stage=progress.stage
        )
        search = Search(options.preset, workers=workers)
        recorded = learn_from_recording(rig, options.seed, search, progress)
    progress.stage("all motions")
    studied = replace(reproduction, extras=extras, published=study)
    return with_motions(studied, fmus, recorded, workers)


def with_motions(
    reproduction: Reproduction, fmus: Path, recorded: Learned | None = None, workers: int = 1
) -> Reproduction:
    """Return a reproduction, whose FMUs are in a folder, with what its steps do in all motions."""
    options, study = reproduction.options, reproduction.published
    entries = steps(reproduction.identification, reproduction.learned, recorded)
    rig = options.rig(fmus)
    motions = evaluate(rig, entries, phases=PHASES, workers=workers)
    if study is not None:
        coarse = {"as_published": OURS, "least_squares_coarse": SQUARES}
        of_seeds = {name: study.evaluation.errors[method] for name, method in coarse.items()}
        motions = replace(motions, errors={**motions.errors, **of_seeds})
    return replace(reproduction, motions=motions)


def reproduce_with_extras(options: Options, fmus: Path, progress: Progress) -> Extras:
    """Take the steps on the drive with all effects on; ``fmus`` is made."""
    fmus.mkdir()
    progress.stage("the same on the drive with all extras on")
    parameters = (v for v in models.load_model("drive").variables if v.role == "parameter")
    effects = {v.name: True for v in parameters if v.type == "boolean"}
    options = replace(options, seeds=0, truth={**options.truth, **effects})
    try:
        found = reproduce(options, fmus, progress)
        return Extras(step_by_step(found, fmus))
    except Fault as fault:
        return Extras(None, reason=str(fault))


def step_by_step(found: Reproduction, fmus: Path) -> pd.DataFrame:
    """Return Table 4 of a reproduction with a column for each step that takes no study."""
    options = found.options
    rig = options.rig(fmus)
    entries = steps(found.identification, found.learned)
    evaluation = evaluate(rig, entries, motions=[TRAPEZOID], phases=PHASES)
    return with_steps(found.validation.table(), evaluation)
