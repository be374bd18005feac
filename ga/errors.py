"""Errors of the learning."""

from __future__ import annotations

from pathlib import Path

from stickslip.fmi.errors import Fault


class GaError(Fault):
    """Something about a learning run is wrong."""


class SettingsError(GaError, ValueError):
    """A gene, a setting or a repair makes no sense."""


class CostError(GaError, ValueError):
    """Costs told to the algorithm do not fit the candidates it asked about."""


class StateError(GaError, ValueError):
    """A checkpoint belongs to another problem, or is no checkpoint."""


class CallOrderError(GaError, RuntimeError):
    """``ask`` and ``tell`` were called out of turn."""


class CandidateFailed(GaError):
    """A candidate cannot be evaluated: its cost is infinite, and its message is the reason."""


class NothingLearned(GaError):
    """Every candidate of the first generation failed. The message gives the first reason."""


class WorkersLost(GaError, RuntimeError):
    """A Dask cluster cannot be reached any more, or has no workers."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a run. The message says what is kept and how to go on.

    Attributes
    ----------
    checkpoint : where the run can be resumed from, if it is kept at all
    generations, evaluations : what is in it
    """

    def __init__(self, checkpoint: Path | None, generations: int, evaluations: int) -> None:
        self.checkpoint, self.generations, self.evaluations = checkpoint, generations, evaluations
        if checkpoint is None:
            kept = "nothing is kept, because no checkpoint was asked for"
        elif not generations:
            kept = "nothing is kept, because no generation was done"
        else:
            kept = f"they are kept in {checkpoint}; continue with resume=True"
        super().__init__(
            f"interrupted after {generations} generations ({evaluations} evaluations); {kept}"
        )
