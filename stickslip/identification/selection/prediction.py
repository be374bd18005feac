"""A friction law fitted to one part of a recording, and its prediction of the other part."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.stats import qmc
from threadpoolctl import threadpool_limits

from stickslip.catalog.space import ParameterSpace
from stickslip.identification.criteria.inverse_model import EDGE, ForceCost, InverseModel
from stickslip.identification.criteria.scaling import recording_scale
from stickslip.identification.estimation.candidate_fmus import candidate_fmus
from stickslip.identification.fitting.fit import Fit, fit, inverse_information
from stickslip.identification.fitting.multistart import SURE, select, variants
from stickslip.identification.fitting.search import solve_linear
from stickslip.identification.fitting.start import Start, begin
from stickslip.identification.selection.candidates import Candidate, candidates
from stickslip.identification.selection.folds import blocks, folds
from stickslip.identification.selection.noise import encoder_error, explained
from stickslip.logs import Recording
from stickslip.servo.measurement import Array

POINTS = 32
"""Points at which the friction parameters are tried before the fits."""
STARTS = 2
"""Best of these from which a fit starts, beside the straight line."""
REACH = 1.0
"""Distance of the points from the prior mean, in prior standard deviations."""
STEPS = 2
"""Gauss steps from the fit of all samples to that of a fold."""


@dataclass(frozen=True)
class Prediction:
    """What a friction law explains of a recording, in SI units.

    Attributes
    ----------
    candidate : the law
    parameters : fitted to the whole recording, by name
    errors : their standard errors by name
    force : root mean square of measured minus predicted force where held out [N]
    relative : the same over that of the measured force
    explained : root mean square that noise and the steps of encoder and force make [N]
    squares : (blocks,) mean square of the held-out error of each block [N^2]
    """

    candidate: Candidate
    parameters: dict[str, float]
    errors: dict[str, float]
    force: float
    relative: float
    explained: float
    squares: Array


def predictions(
    recording: Recording,
    gains: Mapping[str, float] | None = None,
    among: Iterable[Candidate] | None = None,
    workers: int = 1,
) -> list[Prediction]:
    """Return the prediction of each law of the catalogue, or of those given.

    Parameters
    ----------
    gains : of a controller that is known to command the logged force

    Raises
    ------
    IdentificationError
        When the recording does not show a drive that slides.
    UsageError
        When it lacks a signal.
    """
    scale = recording_scale(recording)
    scaled = scale.recording(recording)
    found = []
    gains = None if gains is None else scale.values(gains)
    with threadpool_limits(limits=1, user_api="blas"):
        for candidate in candidates() if among is None else among:
            with (
                candidate_fmus(candidate.law.name) as fmus,
                InverseModel(fmus, scaled, workers=workers, law=candidate.law) as inverse,
            ):
                fitted = _fitted(inverse, begin(inverse, scaled), candidate)
                one = predict(inverse, fitted, fmus, scaled, candidate, gains)
            found.append(
                replace(
                    one,
                    parameters=scale.restored(one.parameters),
                    errors=scale.restored(one.errors),
                    force=one.force / scale.force,
                    explained=one.explained / scale.force,
                    squares=one.squares / scale.force**2,
                )
            )
    return found


def predict(
    inverse: InverseModel,
    fitted: Fit,
    fmus: Path,
    recording: Recording,
    candidate: Candidate,
    gains: Mapping[str, float] | None = None,
) -> Prediction:
    """Return what a fit by the inverse model to the whole recording predicts of its parts."""
    residual = held_out(inverse, fitted)
    count = np.bincount(blocks(len(residual)))
    encoder = encoder_error(inverse, fitted.parameters, fmus, recording, gains)
    force = float(np.sqrt(np.mean(residual**2)))
    measured = inverse.measured(fitted.parameters)[inverse.used]
    return Prediction(
        candidate,
        fitted.parameters,
        fitted.errors(),
        force,
        force / max(float(np.sqrt(np.mean(measured**2))), np.finfo(float).tiny),
        explained(inverse, fitted.residual, encoder),
        np.bincount(blocks(len(residual)), residual**2) / count,
    )


def held_out(inverse: InverseModel, fitted: Fit) -> Array:
    """Return measured minus predicted force (k,) [N], each sample by a fit that did not see it.

    The fit of a fold follows from that of all samples by Gauss steps with its Jacobian.
    """
    space, jacobian = fitted.space, fitted.jacobian
    free = (fitted.q > space.lower + 1e-6) & (fitted.q < space.upper - 1e-6)
    jacobian = np.where(free, jacobian, 0.0)
    weight = np.where(np.isfinite(space.prior_deviation), space.prior_deviation, np.inf) ** -2.0
    variance = max(fitted.noise, np.finfo(float).tiny)
    memory = int(EDGE / inverse.cutoff / inverse.T_s) + 1
    found = np.empty_like(fitted.residual)
    for fold in folds(len(found), memory):
        rows = jacobian[fold.fitted]
        inverse_matrix = inverse_information(rows, variance, space)
        q, rest = fitted.q, fitted.residual
        for _ in range(STEPS):
            pull = weight * (q - space.prior_mean)
            step = inverse_matrix @ (rows.T @ rest[fold.fitted] / variance + pull)
            q = np.clip(q - np.where(free, step, 0.0), space.lower, space.upper)
            rest = inverse.over(space).residual(space.decode(q))
        found[fold.held_out] = rest[fold.held_out]
    return found


def _fitted(inverse: InverseModel, start: Start, candidate: Candidate) -> Fit:
    """Return the fit from the best of several points, with the choices such as an exponent."""
    space = candidate.restricted(start.space)
    criterion = inverse.over(space)
    starts = [space.encode(start.line), *_points(criterion, start, space)]
    return select(variants(criterion, fit(criterion, starts)), SURE).fit


def _points(inverse: InverseModel, start: Start, space: ParameterSpace) -> list[Array]:
    """Return the best of points (k,) spread over the friction parameters."""
    low, high = _range(space)
    varied = np.flatnonzero(high > low)
    cost = ForceCost.of(inverse, start.line["delay"])
    line = space.encode(start.line)
    found = []
    for point in qmc.Sobol(len(varied), seed=0).random(POINTS):
        q = line.copy()
        q[varied] = low[varied] + (high - low)[varied] * point
        values = space.decode(q)
        friction = np.array([values[name] for name in space.friction])
        found.append((cost.of_friction(inverse.friction(values)), friction))
    found.sort(key=lambda one: one[0])
    return [space.encode(solve_linear(inverse, start, friction)) for _, friction in found[:STARTS]]


def _range(space: ParameterSpace) -> tuple[Array, Array]:
    """Return bounds (k,) of the points; both are alike where a coordinate is not varied."""
    known = np.isfinite(space.prior_deviation)
    known &= [name in space.law.parameters for name in space.names]
    reach = np.where(known, REACH * space.prior_deviation, 0.0)
    low, high = (np.clip(space.prior_mean + r, space.lower, space.upper) for r in (-reach, reach))
    return np.where(known, low, 0.0), np.where(known, high, 0.0)
