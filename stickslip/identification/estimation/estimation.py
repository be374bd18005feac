"""The task of an estimation, and its result."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd

from stickslip import ga
from stickslip.catalog.parameters import DRIVE
from stickslip.identification.controller.controller_check import ControllerCheck
from stickslip.identification.criteria.goodness_of_fit import GoodnessOfFit
from stickslip.identification.criteria.scaling import SI, Scale
from stickslip.identification.fitting.fit import Fit
from stickslip.identification.fitting.identifiability import Identifiability
from stickslip.identification.fitting.search import Search
from stickslip.identification.fitting.start import Start
from stickslip.identification.selection import Choice, Prediction
from stickslip.identification.sliding.friction_curve import FrictionCurve
from stickslip.logs import Finding, Recording
from stickslip.models import Law

CriterionName = Literal["auto", "output error", "inverse model"]
OnGeneration = Callable[[ga.Optimiser, Scale], object]
"""Called after each generation with the search, and the scale of its values."""


@dataclass(frozen=True)
class Task:
    """The task of an estimation.

    Attributes
    ----------
    fmus : folder of the FMUs
    gains : of the controller FMU by name; None when the controller is not known
    criterion : compares candidates with the recording; ``auto`` takes the one that it allows
    search : which algorithm, where it runs
    seed : of the search
    seeds : how many searches, each with a seed of its own
    law : friction law of the FMUs
    faults : findings of the checks that invalidate intervals or values
    choice : of the law among all; None where the law is given
    """

    fmus: Path
    recording: Recording
    gains: Mapping[str, float] | None = None
    criterion: CriterionName = "auto"
    search: Search = field(default_factory=Search)
    seed: int = 0
    seeds: int = 1
    law: str = "lugre"
    faults: tuple[Finding, ...] = ()
    choice: Choice | None = None

    @property
    def is_level(self) -> bool:
        """Whether friction does not rise towards rest, by the choice of the law."""
        return self.choice is not None and self.choice.chosen.candidate.is_level

    @property
    def workers(self) -> int:
        """Number of parallel runs of an experiment."""
        return self.search.execution.workers


@dataclass(frozen=True)
class Estimation:
    """The result of an estimation.

    Attributes
    ----------
    criterion, reason : the criterion of the result, and why
    fit : with coordinates, residual and covariance
    known : identifiability by name: the law's parameters, m and b
    parameters, errors : all values by name and their standard errors, SI
    profiles : see ``identifiability.profiles``
    searches : a row for each seed: seed, evaluations, cost, the values of the local fit
    algorithm : the search that led to the result
    figures : goodness of fit
    controller : the check of the controller; None when it is not known
    remarks : changes made to the recording
    model_error : residual of the loop over that from encoder and noise; NaN without the loop
    faults : those of the task, and those that learning found; no parameter is identifiable then
    plausible : all values by name that the recording supports: the fit's, and draws from its
        covariance
    largest_friction : at standstill and creep in the recording [N]
    predictions : of the law where it was not fitted, and of the other laws where they were tried
    choice : of the law among all; None where the law was given
    friction_curve : friction against speed without a law; None where the drive slides too little
    """

    recording: Recording
    criterion: str
    reason: str
    start: Start
    fit: Fit
    known: dict[str, Identifiability]
    parameters: dict[str, float]
    errors: dict[str, float]
    profiles: pd.DataFrame
    searches: pd.DataFrame
    algorithm: ga.Optimiser
    figures: GoodnessOfFit
    controller: ControllerCheck | None
    model_error: float
    gains: Mapping[str, float] | None = None
    remarks: tuple[str, ...] = ()
    faults: tuple[Finding, ...] = ()
    plausible: tuple[Mapping[str, float], ...] = ()
    largest_friction: float = float("inf")
    predictions: tuple[Prediction, ...] = ()
    choice: Choice | None = None
    friction_curve: FrictionCurve | None = None

    def spread(self) -> dict[str, float]:
        """Return the largest relative difference between searches by parameter; 0 for one search.

        It is that of the fits after the searches, by the inverse model. A difference shows
        several local minima, while standard errors take only one into account.
        """
        values = self.searches[list(self.fit.space.reported)]
        return {name: float(np.ptp(values[name]) / values[name].abs().max()) for name in self.known}

    @property
    def F_0(self) -> float:  # noqa: N802 - the symbol
        """Constant force against the motor [N]."""
        return self.parameters["F_0"]

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

    @property
    def delay(self) -> float:
        """Of the force, beyond the log's own [s]."""
        return self.parameters["delay"]


def restored(estimation: Estimation, scale: Scale) -> Estimation:
    """Return the estimation of a scaled recording in SI units; ``fit`` stays scaled."""
    if scale == SI:
        return estimation
    known = {
        name: replace(
            one,
            value=one.value / scale.of(name),
            standard_error=one.standard_error / scale.of(name),
            low=one.low / scale.of(name),
            high=one.high / scale.of(name),
        )
        for name, one in estimation.known.items()
    }
    profile, searches = estimation.profiles.copy(), estimation.searches.copy()
    profile["value"] /= profile["parameter"].map(scale.of)
    for name in estimation.fit.space.reported:
        searches[name] /= scale.of(name)
    searches["cost"] /= scale.force**2
    back = Scale(1.0 / scale.force, 1.0 / scale.length)
    check = estimation.controller
    return replace(
        estimation,
        recording=back.recording(estimation.recording),
        start=replace(estimation.start, line=scale.restored(estimation.start.line)),
        known=known,
        parameters=scale.restored(estimation.parameters),
        errors=scale.restored(estimation.errors),
        profiles=profile,
        searches=searches,
        figures=estimation.figures.scaled(back),
        controller=check
        and replace(check, force=check.force / scale.force, gains=scale.restored(check.gains)),
        gains=None if estimation.gains is None else scale.restored(estimation.gains),
        plausible=tuple(map(scale.restored, estimation.plausible)),
        largest_friction=estimation.largest_friction / scale.force,
        friction_curve=estimation.friction_curve and estimation.friction_curve.restored(scale),
    )
