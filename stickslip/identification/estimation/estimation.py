"""The result of an estimation."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import pandas as pd

from stickslip import ga
from stickslip.catalog.parameters import DRIVE
from stickslip.identification.criteria.controller_check import ControllerCheck
from stickslip.identification.criteria.goodness_of_fit import GoodnessOfFit
from stickslip.identification.criteria.motion import SI, Scale
from stickslip.identification.estimation.faults import HeldOut
from stickslip.identification.fitting.fit import Fit
from stickslip.identification.fitting.identifiability import Identifiability
from stickslip.identification.fitting.start import Start
from stickslip.identification.selection.choice import Choice
from stickslip.identification.sliding.position_force import PositionForce
from stickslip.logs import Finding, Recording
from stickslip.models import Law


@dataclass(frozen=True)
class Estimation:
    """The result of an estimation."""

    recording: Recording
    criterion: str  # that of the result
    reason: str  # why it is that
    start: Start  # a straight line through the force, and the friction curve without a law
    fit: Fit  # of the law, with coordinates, residual and covariance
    known: dict[str, Identifiability]  # identifiability by name: the law's parameters, m and b
    # all values by name, in SI units; the delay is that of the force, beyond the log's own
    parameters: dict[str, float]
    errors: dict[str, float]  # their standard errors, in SI units
    profiles: pd.DataFrame  # see ``identifiability.profiles``
    searched: ga.Optimiser  # the global search that came before the fit, on the scaled recording
    held_out: HeldOut  # what the law, and others that were tried, predict there
    figures: GoodnessOfFit  # goodness of fit
    controller: ControllerCheck | None  # the check of the controller; None when it is not known
    model_error: float  # residual of the loop over that from encoder and noise, or NaN
    # all values by name that the recording supports: the fit's, and draws from its covariance
    plausible: tuple[Mapping[str, float], ...] = ()
    largest_friction: float = float("inf")  # at standstill and creep in the recording [N]
    gains: Mapping[str, float] | None = None  # of the controller FMU by name; None if unknown
    remarks: tuple[str, ...] = ()  # changes made to the recording
    faults: tuple[Finding, ...] = ()  # of the task, or found: no parameter is identifiable
    choice: Choice | None = None  # of the law among all; None where the law was given
    # known beside mass and friction: gravity and cogging, in SI units; None for none
    position_force: PositionForce | None = None

    @property
    def law(self) -> Law:
        """The friction law of the drive that was fitted."""
        return self.fit.space.law

    @property
    def chosen(self) -> dict[str, float]:
        """The parameters of the law that are selected or constant, such as an exponent."""
        return {name: self.parameters[name] for name in self.fit.space.constants}

    @property
    def compensator(self) -> dict[str, float]:
        """The compensator's parameters by name, in SI units: those of the law."""
        return {name: value for name, value in self.parameters.items() if name not in DRIVE}


def restored(estimation: Estimation, scale: Scale) -> Estimation:
    """Return the estimation of a scaled recording in SI units; ``fit`` stays scaled."""
    if scale == SI:
        return estimation
    back = Scale(1.0 / scale.force, 1.0 / scale.length)
    check, sizes = estimation.controller, ("value", "standard_error", "low", "high")
    known = {
        name: replace(one, **{size: getattr(one, size) / scale.of(name) for size in sizes})
        for name, one in estimation.known.items()
    }
    profiles = estimation.profiles.copy()
    profiles["value"] /= profiles["parameter"].map(scale.of)
    return replace(
        estimation,
        recording=back.recording(estimation.recording),
        start=estimation.start.restored(scale),
        known=known,
        parameters=scale.restored(estimation.parameters),
        errors=scale.restored(estimation.errors),
        profiles=profiles,
        plausible=tuple(map(scale.restored, estimation.plausible)),
        largest_friction=estimation.largest_friction / scale.force,
        figures=estimation.figures.scaled(back),
        controller=check
        and replace(check, force=check.force / scale.force, gains=scale.restored(check.gains)),
        gains=None if estimation.gains is None else scale.restored(estimation.gains),
    )
