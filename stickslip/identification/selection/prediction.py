"""A friction law fitted to one part of a recording, and its prediction of the other part."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import qmc
from threadpoolctl import threadpool_limits

from stickslip import models
from stickslip.catalog.parameters import ParameterSpace, friction_law, presliding
from stickslip.identification.criteria.controller_check import check_controllers
from stickslip.identification.criteria.inverse_model import EDGE, ForceCost, InverseModel
from stickslip.identification.criteria.known_loop import fmu_gains
from stickslip.identification.criteria.motion import Scale, against_motion, recording_scale
from stickslip.identification.criteria.runs import candidate_fmus
from stickslip.identification.fitting.fit import (
    BLOCKS,
    ROUGH,
    Fit,
    fit,
    inverse_information,
    plausible,
)
from stickslip.identification.fitting.identifiability import NOT_IDENTIFIABLE, identifiability
from stickslip.identification.fitting.search import select, solve_linear, variants
from stickslip.identification.fitting.start import Start, begin
from stickslip.identification.held_out import Fold, folds, mean_squares
from stickslip.identification.selection.folds import Moving, encoder_error, explained, moving
from stickslip.logs import Recording
from stickslip.models import Law
from stickslip.output import steps
from stickslip.servo.measurement import Array
from stickslip.thresholds import control_match, law_choice


@dataclass(frozen=True)
class Candidate:
    """A friction law, or its case in which friction does not rise towards rest."""

    law: Law  # of the catalogue
    is_level: bool = False  # whether parameters with a lower bound, as F_s, are held there

    @property
    def title(self) -> str:
        """The display name: that of law.toml, and what is held."""
        if not self.is_level:
            return self.law.title
        held = (f"{name} = {bound}" for name, bound in ParameterSpace.of(self.law).bounded.items())
        return f"{self.law.title} with {', '.join(held)}"


def candidates() -> tuple[Candidate, ...]:
    """Return Coulomb and viscous friction alone (a level case), then the laws, LuGre first."""
    every = map(friction_law, dict.fromkeys(("lugre", *models.law_names())))
    laws = [law for law in every if law.is_candidate]
    static = [law for law in laws if not presliding(law) and ParameterSpace.of(law).bounded]
    return (*(Candidate(law, is_level=True) for law in static[:1]), *map(Candidate, laws))


POINTS = 32  # points at which the friction parameters are tried before the fits
STARTS = 2  # best of these from which a fit starts, beside the straight line
REACH = 1.0  # distance of the points from the prior mean, in prior standard deviations
STEPS = (1.0, 0.3, 1.0)  # shares of the Gauss steps to the fit of a fold; bad ones are skipped
AT_BOUND = 1e-6  # distance from a bound below which a coordinate stays there


@dataclass(frozen=True)
class Prediction:
    """What a friction law explains of a recording, in SI units."""

    candidate: Candidate  # the law
    parameters: dict[str, float]  # fitted to the whole recording, by name
    errors: dict[str, float]  # their standard errors by name
    force: float  # root mean square of measured minus predicted force where held out [N]
    relative: float  # the same over that of the measured force
    explained: float  # root mean square that noise and the steps of encoder and force make [N]
    squares: Array  # (blocks,) mean square of the held-out error of each block [N^2]
    shown: tuple[str, ...]  # parameters beyond Coulomb friction that the recording identifies
    moving: Moving | None = None  # beside a regression where the drive moves, if compared
    # all values by name that the recording supports: those fitted, and draws from their covariance
    plausible: tuple[Mapping[str, float], ...] = ()

    @property
    def fails(self) -> bool:
        """Whether Coulomb and viscous friction alone is better while the drive moves."""
        return self.moving is not None and self.moving.fails and not self.candidate.is_level

    @property
    def ratio(self) -> float:
        """Held-out error over the one that noise and steps explain."""
        return self.force / max(self.explained, np.finfo(float).tiny)

    @property
    def unexplained(self) -> float:
        """Root mean square of what noise and steps do not explain [N]."""
        return float(np.sqrt(max(self.force**2 - self.explained**2, 0.0)))

    @property
    def measured(self) -> float:
        """Root mean square of the measured force [N]."""
        return self.force / max(self.relative, np.finfo(float).tiny)

    def restored(self, scale: Scale) -> "Prediction":
        """Return the prediction of a scaled recording in SI units."""
        return replace(
            self,
            parameters=scale.restored(self.parameters),
            errors=scale.restored(self.errors),
            force=self.force / scale.force,
            explained=self.explained / scale.force,
            squares=self.squares / scale.force**2,
            moving=self.moving and self.moving.scaled(1.0 / scale.force),
            plausible=tuple(map(scale.restored, self.plausible)),
        )


def predictions(
    recording: Recording,
    gains: Mapping[str, float] | None = None,  # used if the controller commands the force
    among: Iterable[Candidate] | None = None,
    workers: int = 1,
) -> list[Prediction]:
    """Return the prediction of each law of the catalogue, or of those given."""
    scale = recording_scale(recording)
    scaled, _ = against_motion(scale.recording(recording))
    found = []
    with threadpool_limits(limits=1, user_api="blas"):
        if gains is not None:
            scaled, gains = _believed(scaled, scale.values(gains))
        for candidate in steps(candidates() if among is None else tuple(among)):
            with (
                candidate_fmus(candidate.law.name) as fmus,
                InverseModel(fmus, scaled, workers=workers, law=candidate.law) as inverse,
            ):
                fitted = _fitted(inverse, candidate, scale)
                one = predict(inverse, fitted, candidate, gains)
            found.append(one.restored(scale))
    return found


def _believed(
    recording: Recording, gains: Mapping[str, float]
) -> tuple[Recording, Mapping[str, float] | None]:
    """Return the gains, with the controller's initial state, if they command the logged force."""
    with candidate_fmus() as fmus:
        found, check = check_controllers(fmus, recording, fmu_gains(gains))
    return found, check.gains if check.error <= control_match.EXACT else None


def predict(
    inverse: InverseModel,
    fitted: Fit,
    candidate: Candidate,
    gains: Mapping[str, float] | None = None,  # of a controller that commands the logged force
    residual: Array | None = None,  # of ``held_out``, where it is there already
) -> Prediction:
    """Return what a fit by the inverse model to the whole recording predicts of its parts."""
    residual = held_out(inverse, fitted) if residual is None else residual
    everywhere = np.ones(len(residual), dtype=bool)
    encoder = encoder_error(inverse, fitted.parameters, gains)
    force = float(np.sqrt(np.mean(residual**2)))
    measured = inverse.measured(fitted.parameters)[inverse.used]
    split = folds(len(residual), memory(inverse))
    return Prediction(
        candidate,
        fitted.parameters,
        fitted.errors(),
        force,
        relative=force / max(float(np.sqrt(np.mean(measured**2))), np.finfo(float).tiny),
        explained=explained(inverse, fitted.residual, encoder),
        squares=mean_squares(residual, everywhere),
        shown=_shown(fitted),
        moving=moving(inverse, fitted.parameters, residual, split),
        plausible=plausible(fitted, 0),
    )


def _shown(fitted: Fit) -> tuple[str, ...]:
    """Return what is identified of presliding, and of a rise towards rest that is one."""
    space, errors, degrees = fitted.space, fitted.errors(), BLOCKS - len(fitted.q)
    spread = np.sqrt(np.maximum(np.diag(fitted.covariance), 0.0))
    rises = any(
        fitted.q[space.index(name)] > law_choice.RISES * spread[space.index(name)]
        for name in space.bounded
    )
    names = dict.fromkeys((*presliding(space.law), *(space.rise if rises else ())))
    known = {name: identifiability(name, fitted, errors, degrees) for name in names}
    return tuple(n for n, one in known.items() if one.identifiability != NOT_IDENTIFIABLE)


def held_out(inverse: InverseModel, fitted: Fit) -> Array:
    """Return measured minus predicted force (k,) [N], each sample by a fit that did not see it."""
    found = np.empty_like(fitted.residual)
    for fold in folds(len(found), memory(inverse)):
        found[fold.held_out] = _without(inverse, fitted, fold)[fold.held_out]
    return found


def memory(inverse: InverseModel) -> int:
    """Return the number of samples over which the low-pass mixes them."""
    return int(EDGE / inverse.cutoff / inverse.T_s) + 1


def _without(inverse: InverseModel, fitted: Fit, fold: Fold) -> Array:
    """Return the residual (k,) of the fit of a fold's samples."""
    space, used = fitted.space, fold.fitted
    variance = max(fitted.noise, np.finfo(float).tiny)
    free = (fitted.q > space.lower + AT_BOUND) & (fitted.q < space.upper - AT_BOUND)
    rows = np.where(free, fitted.jacobian[used], 0.0)
    matrix = inverse_information(rows, variance, space)

    def loss(q: Array, rest: Array) -> float:
        return float(rest[used] @ rest[used]) / variance + float(
            np.sum(space.prior_residual(q) ** 2)
        )

    weight = space.prior_deviation**-2.0  # 0 where there is no prior
    q, rest = fitted.q, fitted.residual
    for share in STEPS:
        pull = weight * (q - space.prior_mean)
        step = matrix @ (rows.T @ rest[used] / variance + pull)
        trial = np.clip(q - share * np.where(free, step, 0.0), space.lower, space.upper)
        left = inverse.residual(space.decode(trial))
        if loss(trial, left) < loss(q, rest):
            q, rest = trial, left
    return rest


def _fitted(inverse: InverseModel, candidate: Candidate, scale: Scale) -> Fit:
    """Return the fit from the best of several points, which are compared on fewer rows."""
    recording = inverse.recording
    start = begin(inverse, recording, scale)
    space = start.space.level() if candidate.is_level else start.space
    cutoff, law, q = inverse.cutoff, candidate.law, inverse.every * inverse.q
    with InverseModel(inverse.fmus, recording, cutoff, law=law, q=q) as thin:
        criterion = thin.over(space)
        starts = [space.encode(start.line), *_points(criterion, start, space)]
        found = select(
            variants(criterion, fit(criterion, starts, ROUGH), ROUGH), law_choice.EXPONENT
        ).fit
    return fit(inverse.over(found.space), [found.q], ROUGH)


def _points(inverse: InverseModel, start: Start, space: ParameterSpace) -> list[Array]:
    """Return the best of points (k,) spread over the friction parameters."""
    low, high = _range(space)
    varied = np.flatnonzero(high > low)
    q = space.encode(start.line)
    frictions = []
    for point in qmc.Sobol(len(varied), seed=0).random(POINTS):
        q[varied] = low[varied] + (high - low)[varied] * point
        values = space.decode(q)
        frictions.append([values[name] for name in space.friction])
    rows = np.array(frictions)
    costs = ForceCost(inverse, space.friction, start.line["delay"]).together(rows)
    best = np.argsort([cost() for cost in costs], kind="stable")[:STARTS]
    return [space.encode(solve_linear(inverse, start, friction)) for friction in rows[best]]


def _range(space: ParameterSpace) -> tuple[Array, Array]:
    """Return bounds (k,) of the points; both are alike where a coordinate is not varied."""
    known = np.isfinite(space.prior_deviation)
    known &= [name in space.law.parameters for name in space.names]
    reach = np.where(known, REACH * space.prior_deviation, 0.0)
    low, high = (np.clip(space.prior_mean + r, space.lower, space.upper) for r in (-reach, reach))
    return np.where(known, low, 0.0), np.where(known, high, 0.0)
