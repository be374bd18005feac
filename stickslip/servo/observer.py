"""Design of a disturbance observer for a velocity loop: as fast as robustness and noise allow.

The gains are those of a stationary Kalman filter, whose two weights, the noise of the force and the
rate of the disturbance, are searched relative to the step of the encoder. Each candidate has a peak
sensitivity, the largest over the given masses, and an expected velocity error, whose mean square is

    integral of  r (2 F_c)^2 |G(f) / (2 pi f)|^2 + T_s step^2 / 12 |H(f)|^2 + T_s s_F^2 |K(f)|^2  df

over positive and negative frequencies up to half the sample rate, with G, H and K from a force on
the mass, an error of the encoder and one of the measured force to the velocity. The first term is
a step of twice the Coulomb friction r times a second, the others quantisation and noise. Of the
candidates within the limit of the peak sensitivity, the one is taken for which the product of peak
sensitivity and expected error is least: 1 % less error at 2 % more sensitivity is not better. Where
quantisation by a coarse encoder hides friction in the error, the product with the first term alone
decides, among the candidates that increase the error by ``QUIET`` at most.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np

from stickslip.servo.axis import ControlError, check
from stickslip.servo.sensitivity import OpenLoop, Response, peak_sensitivity
from stickslip.servo.velocity_filter import FilterSpecification, Observer, design_velocity_filter
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.thresholds import offer

MASSES = (0.9, 1.0, 1.1)  # true masses, relative to that of the axis, at which the limit holds
REVERSALS = 0.1
"""Reversals of Coulomb friction per second, r. A real one is spread over the presliding distance,
so that it excites high frequencies less than a step does."""
FORCE_NOISE = 0.01  # default standard deviation of the measured force, relative to the friction
QUIET = 0.02  # share by which the whole error may grow where the encoder hides friction in it
LEAST_GAIN = 1e-3  # relative improvement below which the search ends
Weights = tuple[float, float]
_RATES = np.geomspace(1e-10, 10.0, 12)
_NOISES = np.geomspace(1e-6, 30.0, 8)
_STEPS = (2.0, 1.4, 1.15)  # factors of the search around the best of these


@dataclass(frozen=True)
class DesignedObserver:
    """An observer with what it was designed for."""

    observer: Observer  # the design
    sensitivity: float  # largest peak sensitivity at any of the masses, with the observer
    without: float  # the same without it
    error: float  # expected RMS of the velocity error [m/s]
    error_without: float  # the same without it [m/s]
    reversal: float  # what reversals of friction leave of it [m/s]
    reversal_without: float  # the same without it [m/s]
    weights: FilterSpecification  # of the Kalman filter

    def slower(self, factor: float) -> Observer:
        """Return an observer with a rate of the disturbance that is smaller by a factor."""
        rate = factor * self.weights.disturbance_rate
        known = self.observer.filter
        weights = replace(self.weights, disturbance_rate=rate)
        return Observer(design_velocity_filter(known.axis, known.T_s, weights))


def masses_between(low: float, high: float) -> tuple[float, ...]:
    """Return the masses at which limits hold for an interval, relative to that of the axis."""
    return min(MASSES[0], low), 1.0, max(MASSES[-1], high)


def design_observer(
    loop: VelocityLoop,
    encoder_step: float,
    friction: float,
    *,
    force_noise: float | None = None,
    masses: Sequence[float] = MASSES,
    limit: float | None = None,
    order: int = 1,
) -> DesignedObserver:
    """Design the disturbance observer of a velocity loop.

    Parameters
    ----------
    encoder_step : resolution of the encoder [m]
    friction : Coulomb friction [N], to weigh how fast the observer is against its noise
    force_noise : standard deviation of the measured motor force from sample to sample [N], by
        default ``FORCE_NOISE`` of the friction
    masses : true masses at which the limit must hold, relative to that of the loop's axis
    limit : largest peak sensitivity; by default ``thresholds.offer.SENSITIVITY``
    order : of the random walk that the disturbance is taken for, 1 or 2

    Raises
    ------
    ControlError
        When the loop exceeds the limit without an observer, or none reduces the expected error.
    """
    limit = offer.SENSITIVITY if limit is None else limit
    check("encoder_step", encoder_step, loop.axis.unit("m"), encoder_step > 0.0, expected="above 0")
    check("friction", friction, loop.axis.unit("N"), friction > 0.0, expected="above 0")
    check("limit", limit, "1", limit > 1.0, expected="above 1")
    check("order", order, "1", order in (1, 2), expected="1 or 2")
    noise = FORCE_NOISE * friction if force_noise is None else force_noise
    check("force_noise", noise, loop.axis.unit("N"), noise >= 0.0, expected="0 or above")
    opened = [OpenLoop(loop, share * loop.axis.m) for share in masses]
    search = _Search(loop, opened, encoder_step, friction, noise=noise, limit=limit, order=order)
    without = search.tried(None)
    if not (without.peak <= limit and all(one.stable() for one in opened)):
        raise ControlError(
            f"no disturbance observer: the velocity loop alone has a peak sensitivity of"
            f" {max(peak_sensitivity(loop, m=one.m) for one in opened):.3g} when the mass is"
            f" {min(masses):g} to {max(masses):g} times that of its design; expected at most"
            f" {limit:g}; lower K_p or K_i"
        )
    best = search.best(without)
    if best.reversal > offer.HIDDEN * without.reversal:
        best = replace(search, loudest=(1.0 + QUIET) * without.error).best(without)
    if best.reversal > offer.WORTHWHILE * without.reversal or not (best.observer and best.weights):
        raise ControlError(
            f"no disturbance observer with a peak sensitivity of at most {limit:g} reduces what"
            " reversals of friction leave without adding more noise; the controller alone is as"
            " fast as the encoder step and the noise of the force allow"
        )
    return DesignedObserver(
        observer=best.observer,
        sensitivity=best.peak,
        without=without.peak,
        error=best.error,
        error_without=without.error,
        reversal=best.reversal,
        reversal_without=without.reversal,
        weights=best.weights,
    )


class _Candidate(NamedTuple):
    """An observer, or None, its peak sensitivity, expected RMS errors [m/s], and its weights."""

    observer: Observer | None
    peak: float
    error: float
    reversal: float
    weights: FilterSpecification | None = None


@dataclass(frozen=True)
class _Search:
    """Candidates by their weights: rate of the disturbance and noise of the force.

    Both are relative to what moves the axis by one step of the encoder in one sample period. With
    ``loudest``, the largest expected error [m/s], the error of reversals alone is what counts.
    """

    loop: VelocityLoop
    opened: Sequence[OpenLoop]
    step: float
    friction: float
    noise: float
    limit: float
    order: int = 1
    loudest: float | None = None

    def best(self, start: _Candidate) -> _Candidate:
        """Return the best within the limit: of a grid, then around the best of it."""
        best, place = start, None
        for weights in product(_RATES, _NOISES):
            best, place = self._better(best, place, weights)
        for factor in _STEPS:
            moved = place
            while moved is not None:
                around = product((1 / factor, 1.0, factor), repeat=2)
                centre, moved = moved, None
                for by_rate, by_noise in around:
                    weights = centre[0] * by_rate, centre[1] * by_noise
                    best, moved = self._better(best, moved, weights)
                place = moved or centre
        return best

    def _better(
        self, best: _Candidate, place: Weights | None, weights: Weights
    ) -> tuple[_Candidate, Weights | None]:
        """Return the better of a candidate and one with these weights, and its weights."""
        try:
            found = self._designed(*weights)
        except np.linalg.LinAlgError:  # the axis is so slow that no gains follow from the weights
            return best, place
        if found.peak > self.limit or found.error > (self.loudest or np.inf):
            return best, place
        if not self._cost(found) < (1.0 - LEAST_GAIN) * self._cost(best):
            return best, place
        if not all(opened.stable(found.observer) for opened in self.opened):
            return best, place
        return found, weights

    def _cost(self, one: _Candidate) -> float:
        return one.peak * (one.error if self.loudest is None else one.reversal)

    def tried(self, observer: Observer | None) -> _Candidate:
        """Return an observer with what it does at the worst mass."""
        responses = [opened.response(observer) for opened in self.opened]
        peak = max(response.peak for response in responses)
        weights = self.step, self.friction, self.noise
        both = zip(self.opened, responses, strict=True)
        errors = [expected_errors(*one, *weights) for one in both]
        error, reversal = map(max, zip(*errors, strict=True))
        return _Candidate(observer, peak, error, reversal)

    def _designed(self, rate: float, noise: float) -> _Candidate:
        T_s, axis = self.loop.T_s, self.loop.axis
        unit = axis.m * self.step / T_s**2
        per_time = np.sqrt(T_s) * T_s ** (self.order - 1)
        weights = FilterSpecification(self.step, noise * unit, rate * unit / per_time, self.order)
        found = self.tried(Observer(design_velocity_filter(axis, T_s, weights)))
        return found._replace(weights=weights)


def expected_errors(
    opened: OpenLoop, response: Response, encoder_step: float, friction: float, force_noise: float
) -> tuple[float, float]:
    """Return the expected RMS velocity error [m/s] at one mass, whole and that of reversals.

    The response is that of a loop with any observer, at the frequencies of ``opened``. Encoder
    step, friction and noise are as for ``design_observer``.
    """
    f, T_s = opened.f, opened.T_s
    step = 2.0 * friction * np.sqrt(REVERSALS)
    reversal = np.abs(step * response.disturbed / (2.0 * np.pi * f)) ** 2
    quantised = encoder_step**2 / 12 * T_s * np.abs(response.noisy) ** 2
    driven = force_noise**2 * T_s * np.abs(response.driven) ** 2
    densities = (reversal + quantised + driven, reversal)
    whole, first = (float(np.sqrt(2.0 * np.trapezoid(one, f))) for one in densities)
    return whole, first
