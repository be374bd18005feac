"""Logs that were not learned from, and the force that the learned drive predicts of them."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from stickslip.catalog.parameters import Values
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.motion import against_motion, recording_scale
from stickslip.identification.criteria.runs import candidate_fmus
from stickslip.identification.estimation import Estimation
from stickslip.identification.selection.folds import encoder_error, explained
from stickslip.identification.selection.prediction import Candidate
from stickslip.identification.sliding.position_force import with_position_force
from stickslip.logs import Recording


@dataclass(frozen=True)
class PredictedLog:
    """The force of one log, predicted with the values of a law."""

    source: str  # of the log
    law: str  # display name
    error: float  # root mean square of measured minus predicted force [N]
    relative: float  # the same over that of the measured force
    explained: float  # what noise and the steps of the encoder make of it [N]


def predicted_logs(
    estimation: Estimation, recordings: Iterable[Recording], workers: int = 1
) -> Iterator[PredictedLog]:
    """Yield what the learned law, and Coulomb and viscous friction, predict of each log."""
    tried: list[tuple[Candidate, Values]] = [
        (Candidate(estimation.law), estimation.parameters),
        *(
            (o.candidate, o.parameters)
            for o in estimation.held_out.predictions
            if o.candidate.is_level
        ),
    ]
    for recording in recordings:
        recording = replace(recording, known_force=None, friction_factor=None)
        if estimation.position_force is not None:
            recording = with_position_force(recording, estimation.position_force)
        scale = recording_scale(recording)
        scaled, _ = against_motion(scale.recording(recording))
        for candidate, values in tried:
            law, at = candidate.law, scale.values(values)
            with (
                candidate_fmus(law.name) as fmus,
                InverseModel(fmus, scaled, workers=workers, law=law) as inverse,
            ):
                rest = inverse.residual(at)
                force = inverse.measured(at)[inverse.used]
                noise = explained(inverse, rest, encoder_error(inverse, at))
            error = float(np.sqrt(np.mean(rest**2)))
            yield PredictedLog(
                recording.source,
                candidate.title,
                error=error / scale.force,
                relative=error / max(float(np.sqrt(np.mean(force**2))), 1e-300),
                explained=noise / scale.force,
            )
