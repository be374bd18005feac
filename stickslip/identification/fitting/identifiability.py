"""Identifiability of a parameter: interval, profile likelihood, and a sentence.

The profile is the deviance when one parameter is held at another value and all others are fitted
again. Near its minimum it is (distance / standard error)^2.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from scipy.stats import t as student

from stickslip.catalog.parameters import ParameterSpace, Values
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.fitting.fit import Fit, inverse_information
from stickslip.identification.sliding.friction_curve import Interval
from stickslip.models import Law, LawParameter
from stickslip.servo.measurement import Array
from stickslip.thresholds import identifiable

IDENTIFIABLE = "identifiable"
WEAKLY_IDENTIFIABLE = "weakly identifiable"
NOT_IDENTIFIABLE = "not identifiable"
LEVELS = (IDENTIFIABLE, WEAKLY_IDENTIFIABLE, NOT_IDENTIFIABLE)
STIFFNESS = "presliding moves"  # what shows it
VALUE = "{value}"  # place of the value in a template
POINTS = (-3.0, -2.0, -1.0, 1.0, 2.0, 3.0)  # of the profile, in standard errors
PASSES = 3
SETTLED = 0.01  # length of a Gauss step, in deviance, below which a point is not moved again
LOOSE = 0.5  # standard error of a coordinate above which it is held while others are profiled
AT_BOUND = 1e-6  # distance from a bound below which a coordinate is held there


@dataclass(frozen=True)
class Identifiability(Interval):
    """Estimate of one parameter, in SI units."""

    identifiability: str  # one of ``LEVELS``
    # the same for display, with the experiment that shows the parameter, and ``VALUE`` for the
    # value, which may still be scaled
    template: str

    @property
    def sentence(self) -> str:
        """The template with the value."""
        return self.template.replace(VALUE, f"{self.value:.4g}")


def identifiability(name: str, fitted: Fit, errors: Values, degrees: int) -> Identifiability:
    """Return it for a parameter, from standard errors [SI] by name with degrees of freedom."""
    value, error = fitted.parameters[name], errors[name]
    factor = float(student.ppf(0.975, degrees))
    space = fitted.space
    if space.is_log[space.index(name)] and value > 0.0:
        ratio = float(np.exp(min(factor * error / value, 50.0)))
        low, high = value / ratio, value * ratio
        if name not in space.bounded:  # nothing tells of values that no fit may have
            ends = np.exp([bound[space.index(name)] for bound in (space.lower, space.upper)])
            low, high = max(low, min(ends[0], value)), min(high, max(ends[1], value))
    else:
        low, high = value - factor * error, value + factor * error
    interval = Interval(value, error, low, high)
    return _classified(name, interval, space, shown=not _is_prior_dominated(name, fitted))


def of_sliding(
    known: dict[str, Identifiability], sliding: Mapping[str, Interval], space: ParameterSpace
) -> dict[str, Identifiability]:
    """Return the same with the values that sliding motion shows without a law, by name."""
    return known | {
        name: _classified(name, interval, space)
        for name, interval in sliding.items()
        if name in known
    }


def among_laws(
    known: dict[str, Identifiability], others: Iterable[Values], space: ParameterSpace
) -> dict[str, Identifiability]:
    """Return the same with intervals of stiffness that hold that of laws which explain as much."""
    found = dict(known)
    for name, one in known.items():
        shown_by = space.parameters[space.index(name)].shown_by
        values = [values[name] for values in others if name in values]
        if shown_by != STIFFNESS or one.identifiability == NOT_IDENTIFIABLE or not values:
            continue
        low, high = min(one.low, *values), max(one.high, *values)
        wider = Interval(one.value, one.standard_error, low, high)
        found[name] = _classified(name, wider, space)
    return found


def of_ratios(errors: Mapping[str, float], law: Law) -> dict[str, float]:
    """Return standard errors, those of ratios at least as large as what the guide makes of them."""
    ratios = [name for name, one in law.parameters.items() if one.unit == "1" and name in errors]
    return dict(errors) | {name: max(errors[name], identifiable.RATIO) for name in ratios}


def least_errors(
    errors: Mapping[str, float], values: Values, names: Iterable[str], encoder_step: float
) -> dict[str, float]:
    """Return standard errors of what shows in slow motion, which low-pass and sampling bias.

    A contact that bends by few encoder steps [m] looks softer than it is; ``names`` are those of
    presliding.
    """
    least: dict[str, float] = {"F_s": identifiable.STATIC, "v_s": identifiable.STRIBECK}
    if "sigma_0" in values:
        bent = values["F_c"] / values["sigma_0"]
        share = max(identifiable.PRESLIDING, identifiable.QUANTISED * encoder_step / bent)
        least |= dict.fromkeys(names, share)
    return {
        name: max(errors[name], share * values[name])
        for name, share in least.items()
        if name in errors
    }


def beside_force(errors: Mapping[str, float], values: Values) -> dict[str, float]:
    """Return standard errors where a force of position was taken off the force."""
    return {**errors, "F_c": max(errors["F_c"], identifiable.BESIDE_FORCE * values["F_c"])}


def _classified(
    name: str, interval: Interval, space: ParameterSpace, *, shown: bool = True
) -> Identifiability:
    """Return how well a parameter is known; ``shown`` is whether the recording decides it."""
    relative = half_width(name, interval, space)
    if not shown or relative > identifiable.WEAKLY:
        level = NOT_IDENTIFIABLE
        said = f"not identifiable in this experiment; {_remedy(name, space)}"
    elif relative > identifiable.WELL:
        level = WEAKLY_IDENTIFIABLE
        said = f"{WEAKLY_IDENTIFIABLE}, +-{100 * relative:.2g} %; {_remedy(name, space)}"
    else:
        level = IDENTIFIABLE
        said = f"{IDENTIFIABLE}, +-{100 * relative:.2g} %"
    return Identifiability(**vars(interval), identifiability=level, template=said)


def half_width(name: str, interval: Interval, space: ParameterSpace) -> float:
    """Return the relative half-width of an interval, of the logarithm where that is searched."""
    value, half = interval.value, 0.5 * (interval.high - interval.low)
    if space.is_log[space.index(name)] and value > 0.0 and interval.low > 0.0:
        return 0.5 * float(np.log(interval.high / interval.low))
    return half / abs(value) if value else np.inf


def unreliable(known: Identifiability) -> Identifiability:
    """Return a value whose recording is at fault: it is weakly identifiable at best."""
    if known.identifiability != IDENTIFIABLE:
        return known
    template = (
        known.template.replace(IDENTIFIABLE, f"{WEAKLY_IDENTIFIABLE} at best")
        + ", see the warnings"
    )
    return replace(known, identifiability=WEAKLY_IDENTIFIABLE, template=template)


def _remedy(name: str, space: ParameterSpace) -> str:
    shown_by = space.parameters[space.index(name)].shown_by
    return f"{shown_by} show it: stickslip plan --show {name}"


def _is_prior_dominated(name: str, fitted: Fit) -> bool:
    """Tell whether the prior decides more than the recording."""
    space = fitted.space
    index = space.index(name)
    if name in space.rise and space.is_level:
        return True
    deviation = space.prior_deviation[index]
    if not np.isfinite(deviation):
        return False
    room = space.upper[index] - fitted.q[index]
    if name not in space.bounded:  # F_s = F_c is a finding, no bound of the search
        room = min(room, fitted.q[index] - space.lower[index])
    spread = float(np.sqrt(fitted.covariance[index, index]))
    return bool(room < AT_BOUND) or spread > identifiable.PRIOR_DOMINATED * deviation


def profiles(
    fitted: Fit, residuals: Callable[[list[Values]], list[Array]], errors: Values
) -> pd.DataFrame:
    """Return the profile likelihoods: parameter, value [SI] and deviance, 3.84 at 95 %.

    Each point holds one parameter and lets the others follow by up to three Gauss steps with the
    Jacobian of the fit; where that is not enough the curve lies above the true profile. Where a
    bound keeps the parameter from a value there is no point. ``residuals`` returns the residual
    (n,) of each of several points, as the fit saw it; the standard errors by name are in SI units.
    """
    space = fitted.space
    (rest,) = residuals([fitted.parameters])
    information = _Information(fitted, rest)
    points = [
        _Point(name, distance, errors[name], information)
        for name in space.friction
        for distance in POINTS
    ]
    moving = points
    for k in range(PASSES + 1):
        rests = residuals([space.decode(point.q) for point in moving])
        tried, moving = zip(moving, rests, strict=True), []
        for point, rest in tried:
            if k:
                point.losses.append(information.loss(rest, point.q))
            if k < PASSES and (point.advance(rest) > SETTLED or not k):
                moving.append(point)
    middle = [(name, fitted.parameters[name], 0.0) for name in space.friction]
    rows = middle + [point.row() for point in points if point.is_reached]
    table = pd.DataFrame(rows, columns=["parameter", "value", "deviance"])
    return table.sort_values(["parameter", "value"], ignore_index=True)


class _Information:
    """The fit around which profiles are computed, from its residual (n,)."""

    def __init__(self, fitted: Fit, rest: Array) -> None:
        u, self.fitted = fitted.space, fitted
        self.inverse = inverse_information(fitted.jacobian, fitted.noise, u)  # of all coordinates
        # Loose coordinates stay while others are profiled.
        self.loose = np.sqrt(np.diag(self.inverse)) > LOOSE
        self.loose |= np.minimum(fitted.q - u.lower, u.upper - fitted.q) < AT_BOUND
        jacobian = np.where(self.loose, 0.0, fitted.jacobian)
        self.frozen = inverse_information(jacobian, fitted.noise, u)  # of those not loose
        self.frozen[self.loose], self.frozen[:, self.loose] = 0.0, 0.0
        self.weight = 1.0 / u.prior_deviation**2  # of the priors, 0 where there is none
        self.least = self.loss(rest, fitted.q)

    def loss(self, rest: Array, q: Array) -> float:
        """Return twice the negative log likelihood of a residual (n,) at coordinates (k,)."""
        prior = self.fitted.space.prior_residual(q)
        return float(rest @ rest) / self.fitted.noise + float(np.sum(prior**2))


class _Point:
    """One parameter, held at a number of standard errors from its value."""

    def __init__(self, name: str, distance: float, error: float, information: _Information) -> None:
        fitted, space = information.fitted, information.fitted.space
        self._name, self._information = name, information
        self._value = fitted.parameters[name]
        index = space.index(name)
        self._direction = direction = space.direction(name)
        self._held = bool(information.loose[index])  # alone, as the others do not depend on it
        matrix = information.inverse if self._held else information.frozen
        self._plain = float(np.sqrt(direction @ matrix @ direction))
        self._relative = max(error / self._value, 1e-12)
        self._change = distance * self._relative
        self._wanted = float(direction @ fitted.q) + self._change
        self._tolerance = AT_BOUND + 1e-3 * abs(distance) * self._relative
        self.losses: list[float] = []
        self.q = fitted.q.copy()
        if self._held:
            self.q[index] = np.clip(
                self.q[index] + self._change, space.lower[index], space.upper[index]
            )

    def advance(self, rest: Array) -> float:
        """Make a Gauss step from the residual (n,) here; return its length in deviance."""
        around, direction = self._information, self._direction
        fitted, space, frozen = around.fitted, around.fitted.space, around.frozen
        prior = around.weight * (self.q - space.prior_mean)
        step = -frozen @ (fitted.jacobian.T @ rest / fitted.noise + prior)
        if not self._held:
            missing = self._wanted - direction @ (self.q + step)
            step += frozen @ direction * missing / self._plain**2
        before, self.q = self.q, np.clip(self.q + step, space.lower, space.upper)
        return fitted.length(np.where(around.loose, 0.0, self.q - before))

    @property
    def is_reached(self) -> bool:
        """Whether the bounds let the parameter have its value."""
        return abs(float(self._direction @ self.q) - self._wanted) <= self._tolerance

    def row(self) -> tuple[str, float, float]:
        """Return name, value [SI] and deviance."""
        # In the units of the standard error, which takes correlation into account.
        scale = (self._plain / self._relative) ** 2
        deviance = max((min(self.losses) - self._information.least) * scale, 0.0)
        return self._name, self._value * float(np.exp(self._change)), deviance


LARGEST, WEAKEST = "the largest friction in the recording", "where the force is weakest"
CREEP = 0.1  # share of the highest speed up to which friction towards rest shows


def conservative(
    known: Mapping[str, Identifiability], space: ParameterSpace, largest: float
) -> dict[str, Identifiability]:
    """Return the same with the values that the compensator takes.

    Feedforward that is too weak leaves a part of the friction to the controller, as all of it is
    left without a compensator. Feedforward that is too strong, or lasts too long, pushes where
    there is no friction.

    A value with a wide interval is moved to the end of that at which the force is the weakest, but
    for a ratio, which shapes the force; static friction that is not identifiable is the Coulomb
    friction. Unless it is identifiable, it is not above the largest one that the recording shows.
    ``largest`` is that one [N].
    """
    taken = dict(known)
    for name, one in known.items():
        parameter = space.law.parameters.get(name)
        if parameter is None or parameter.at_least or one.identifiability == IDENTIFIABLE:
            continue
        if parameter.unit == "1":
            continue
        wide = half_width(name, one, space) > identifiable.TAKEN
        if wide or one.identifiability == NOT_IDENTIFIABLE:
            template = _template(name, VALUE, one, WEAKEST)
            taken[name] = replace(one, value=_weakest(parameter, one), template=template)
    for name, bound in space.bounded.items():
        one, least = known[name], taken[bound].value
        most = max(identifiable.BEYOND * largest, least)
        if one.identifiability == NOT_IDENTIFIABLE:
            value, what = least, bound
        elif one.identifiability != IDENTIFIABLE and one.value > most:
            value, what = max(largest, least), VALUE
            one = replace(one, low=min(one.low, value / identifiable.BEYOND))
        else:
            value, what = max(one.value, least), ""
        template = _template(name, what, one) if what and value < one.value else one.template
        taken[name] = replace(one, value=value, low=min(one.low, value), template=template)
    return taken


def largest_friction(inverse: InverseModel, values: Values) -> float:
    """Return the largest friction of a recording at standstill and creep, or where slowest [N].

    It is bounded by what was measured and by what the values predict, which has less noise.
    """
    speed = np.abs(inverse.motion.v[inverse.used])
    slow = speed <= max(CREEP * np.quantile(speed, 0.99), speed.min())
    predicted = inverse.friction(values)
    measured = inverse.beside_rigid(values)[inverse.used]
    largest = (np.max(np.abs(one[slow])) for one in (predicted[inverse.used], measured))
    return float(min(largest))


def bounded_by(values: Values, space: ParameterSpace, largest: float) -> dict[str, float]:
    """Return values with static friction from Coulomb friction to the largest one of a log [N]."""
    reduced = {
        name: max(min(values[name], largest), values[bound])
        for name, bound in space.bounded.items()
    }
    return {**values, **reduced}


def _weakest(parameter: LawParameter, one: Identifiability) -> float:
    if parameter.weakest == "high":
        return one.high
    is_contact = (parameter.force, parameter.length) == (1, -1)
    return max(one.low, identifiable.SOFTEST * one.value if is_contact else 0.0)


def _template(name: str, what: str, one: Identifiability, why: str = LARGEST) -> str:
    if one.identifiability != NOT_IDENTIFIABLE:
        return f"{one.template}; {name} = {what} is used, {why}"
    used = f"{name} = {what} is used, {WEAKEST}: {NOT_IDENTIFIABLE}"
    return one.template.replace(NOT_IDENTIFIABLE, used)
