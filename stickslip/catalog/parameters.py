"""Parameters of drives and laws, estimates of them, and the coordinates of an estimation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from stickslip import models
from stickslip.errors import UsageError
from stickslip.models import Law, LawParameter
from stickslip.models.export.units import force_and_length, motion_unit


@dataclass(frozen=True)
class Estimate:
    """A value and its standard error, both in the parameter's unit."""

    value: float
    standard_error: float


LOW, HIGH = "_low", "_high"  # suffixes of the columns of a range, to the name of the median
UNKNOWN = 3.0  # relative standard error of a value that no experiment showed: a factor of e^3


def unseen(value: float) -> Estimate:
    """Return a start value that no experiment showed."""
    return Estimate(value, UNKNOWN * value)


def correlation_length(residual: Array, lags: int | None = None) -> float:
    """Return how many neighbouring samples say the same by autocorrelation; 1 for white noise."""
    centred = residual - residual.mean()
    power = np.abs(np.fft.rfft(centred, 2 * len(centred))) ** 2
    correlation = np.fft.irfft(power)[: len(centred)][:lags]
    if correlation[0] <= 0.0:
        return 1.0
    correlation /= correlation[0]
    below = np.flatnonzero(correlation < 0.05)
    end = below[0] if len(below) else len(correlation)
    return float(1.0 + 2.0 * correlation[1:end].sum())


def covariance(jacobian: Array, residual: Array) -> Array:
    """Return the covariance (k, k) of a fit with this Jacobian (n, k) and residual (n,)."""
    n, k = jacobian.shape
    variance = residual @ residual / max(n - k, 1) * correlation_length(residual)
    return np.asarray(variance * np.linalg.pinv(jacobian.T @ jacobian))


_drive = partial(LawParameter, start=(0.0,), low=-np.inf, high=np.inf, display=None, choices=())
DRIVE = {
    parameter.name: parameter
    for parameter in (
        _drive(
            "m", "kg", "Inertia", symbol="$m$", coordinate="log", force=1, length=-1,
            shown_by="quick ramps of velocity",
        ),
        _drive(
            "b", "N.s/m", "Viscous friction", symbol="$b$", coordinate="linear", force=1,
            length=-1, shown_by="constant speeds over the whole range",
        ),
        _drive(
            "F_0", "N", "Constant force against the motor", symbol="$F_0$", coordinate="linear",
            force=1, length=0,
        ),
        _drive(
            "delay", "s", "Delay of the force against its log or command", symbol="$t_d$",
            coordinate="linear", force=0, length=0,
        ),
    )
}  # fmt: skip
"""The parameters that every drive has, whatever its friction law."""

PAPER = {
    "m": 5.557, "b": 6.6135, "F_s": 8.999, "F_c": 5.999, "v_s": 0.00055697, "sigma_0": 3.9162e5,
    "sigma_1": 4.4248e3,
}  # fmt: skip
"""Table 2 of the paper. It prints b in Nm/sec, which must read N s/m."""


@cache
def friction_law(name: str = "lugre") -> Law:
    """Return a law of ``models/laws``; raise models.UnknownLaw when there is none."""
    return models.load_law(name)


def estimated(law: Law) -> tuple[str, ...]:
    """Return the names of a law's parameters that an experiment shows, in the order of law.toml."""
    return tuple(name for name, parameter in law.parameters.items() if parameter.shown_by)


def learnable_laws() -> list[str]:
    """Return the names of the laws with parameters that an experiment shows."""
    return [name for name in models.law_names() if estimated(friction_law(name))]


def check_learnable(law: str) -> None:
    """Raise UsageError when no experiment shows a law's parameters, UnknownLaw when it is none."""
    if not estimated(friction_law(law)):
        there = ", ".join(learnable_laws())
        raise UsageError(
            f"<law {law}>: no experiment shows its parameters; expected one of {there}"
        )


def tabulated(law: Law) -> tuple[str, ...]:
    """Return the names of a table of identified parameters: m, b and those of the law."""
    return ("m", "b", *estimated(law))


def presliding(law: Law) -> tuple[str, ...]:
    """Return the names of a law's parameters that moves below break-away show."""
    moves = ("presliding moves", "quick presliding moves")
    return tuple(name for name, one in law.parameters.items() if one.shown_by in moves)


def scaled_start(one: LawParameter, F_c: float, deflection: float) -> float:
    """Return a start value for a drive with this friction [N] and presliding deflection [m]."""
    force, length = F_c / PAPER["F_c"], deflection / (PAPER["F_c"] / PAPER["sigma_0"])
    return float(one.start[0] * force**one.force * length**one.length)


@cache
def parameter(name: str) -> LawParameter:
    """Return a parameter of a drive or of any friction law; raise KeyError when there is none."""
    if name in DRIVE:
        return DRIVE[name]
    for law in map(friction_law, ("lugre", *models.law_names())):
        if name in law.parameters:
            return law.parameters[name]
    raise KeyError(name)


def unit_of(name: str, *, rotary: bool = False) -> str:
    """Return the unit of a parameter, for a linear or a rotary drive."""
    return motion_unit(parameter(name).unit, rotary=rotary)


@cache
def start_unit(name: str, *, rotary: bool = False) -> str:
    """Return the unit of a start value of the drive FMU, of any law."""
    try:
        return unit_of(name, rotary=rotary)
    except KeyError:
        units = {one.name: one.unit for one in models.load_model("drive").variables}
        return motion_unit(units[name] or "1", rotary=rotary)


@cache
def force_and_length_of(name: str) -> tuple[int, int]:
    """Return the powers of force and length in a parameter or controller gain; else 0."""
    gains = {v.name: v.unit for v in models.load_model("velocity_controller").variables}
    try:
        return parameter(name).force, parameter(name).length
    except KeyError:
        return force_and_length(gains.get(name) or "1")


LUGRE = estimated(friction_law())  # the parameters of the paper's compensator

UNITS = {name: unit_of(name) for name in PAPER}  # units of Table 2

Array = NDArray[np.float64]
Values = Mapping[str, float]


@dataclass(frozen=True)
class ParameterSpace:
    """The k estimated parameters of a drive with one friction law, and the values held constant.

    A positive parameter has its logarithm as its coordinate, so that decades count alike. Where a
    parameter must not fall below another one, the coordinate is the logarithm of their ratio,
    with a lower bound of 0. Any other coordinate is the value in units of ``units``. All
    coordinates are of the order of 1.
    """

    law: Law  # the friction law
    parameters: tuple[LawParameter, ...]  # the estimated ones, in the order of coordinates
    # the values of further parameters, by name, in SI units; those that start at 0 are switched off
    # and left out
    constants: Mapping[str, float]
    units: Array  # (k,) units of linear coordinates in SI; not used for logarithms
    prior_mean: Array  # (k,) expected coordinates before the recording is seen
    prior_deviation: Array  # (k,) their standard deviations; infinite without a prior
    lower: Array  # (k,)
    upper: Array  # (k,)

    @classmethod
    def of(cls, law: Law) -> ParameterSpace:
        """Return the space of a law's and a drive's parameters, without prior and bounds."""
        names = estimated(law)
        parameters = (*(law.parameters[name] for name in names), *DRIVE.values())
        constants = {
            name: parameter.start[0]
            for name, parameter in law.parameters.items()
            if name not in names and len(parameter.start) == 1 and parameter.start[0] != 0.0
        }
        infinite = np.full(len(parameters), np.inf)
        return cls(
            law,
            parameters,
            constants,
            units=np.ones_like(infinite),
            prior_mean=np.zeros_like(infinite),
            prior_deviation=infinite,
            lower=np.array([0.0 if one.at_least else -np.inf for one in parameters]),
            upper=infinite,
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the estimated parameters."""
        return tuple(parameter.name for parameter in self.parameters)

    @property
    def friction(self) -> tuple[str, ...]:
        """Names of the estimated parameters of the law."""
        return tuple(name for name in self.names if name in self.law.parameters)

    @property
    def reported(self) -> tuple[str, ...]:
        """Names of the parameters that an experiment shows: the law's, and those of the drive."""
        return tuple(parameter.name for parameter in self.parameters if parameter.shown_by)

    @property
    def bounded(self) -> dict[str, str]:
        """Parameters that must not fall below another one, and the name of that one."""
        return {one.name: one.at_least for one in self.parameters if one.at_least}

    @property
    def rise(self) -> tuple[str, ...]:
        """Names of the parameters without effect where each bounded one is at its bound."""
        return tuple(one.name for one in self.parameters if one.at_least or one.requires)

    @property
    def is_level(self) -> bool:
        """Whether each bounded parameter is held at its bound."""
        return all(self.upper[self.index(name)] <= 0.0 for name in self.bounded)

    @property
    def is_log(self) -> NDArray[np.bool_]:
        """Whether each coordinate is a logarithm, (k,)."""
        return np.array([one.coordinate == "log" for one in self.parameters])

    def index(self, name: str) -> int:
        """Return the place of a parameter among the coordinates."""
        return self.names.index(name)

    def encode(self, values: Values) -> Array:
        """Return the coordinates (k,) of values by name, within the bounds."""
        log, bounded = self.is_log, self.bounded
        q = np.array([values[name] for name in self.names])
        bounds = np.array([values[bounded[n]] if n in bounded else 1.0 for n in self.names])
        q[log] = np.log(q[log] / bounds[log])
        q[~log] = q[~log] / self.units[~log]
        return self.inside(q)

    def decode(self, q: Array) -> dict[str, float]:
        """Return the values by name, in SI units, with the constants."""
        log = self.is_log
        numbers = np.empty(len(q))
        numbers[log] = np.exp(q[log])
        numbers[~log] = q[~log] * self.units[~log]
        values = dict(zip(self.names, numbers.tolist(), strict=True)) | dict(self.constants)
        for name, bound in self.bounded.items():
            values[name] *= values[bound]
        return values

    def jacobian(self, q: Array) -> Array:
        """Return d value / d coordinate (k, k)."""
        values, log = self.decode(q), self.is_log
        diagonal = [values[name] for name in self.names]
        slopes = np.diag(np.where(log, diagonal, self.units))
        for name, bound in self.bounded.items():
            if bound in self.names:
                slopes[self.index(name), self.index(bound)] = values[name]
        return slopes

    def direction(self, name: str) -> Array:
        """Return the gradient (k,) of the logarithm of a positive value by the coordinates."""
        direction = np.zeros(len(self.parameters))
        direction[self.index(name)] = 1.0
        bound = self.bounded.get(name)
        if bound in self.names:
            direction[self.index(bound)] = 1.0
        return direction

    def prior_residual(self, q: Array) -> Array:
        """Return (q - prior mean) / prior standard deviation where there is a prior, (j,)."""
        known = np.isfinite(self.prior_deviation)
        return np.asarray(((q - self.prior_mean) / self.prior_deviation)[known])

    def inside(self, q: Array) -> Array:
        """Return coordinates (k,) moved inside the bounds."""
        return np.asarray(np.clip(q, self.lower, self.upper))

    def level(self) -> ParameterSpace:
        """Return the space in which each bounded parameter is held at its bound."""
        upper = self.upper.copy()
        upper[[self.index(name) for name in self.bounded]] = 0.0
        return replace(self, upper=upper)

    def fixed(self, **values: float) -> ParameterSpace:
        """Return the space with these values [SI] as constants; raise KeyError for another name."""
        for name in values:
            if name not in self.names and name not in self.constants:
                raise KeyError(name)
        kept = [k for k, name in enumerate(self.names) if name not in values]
        arrays = ("units", "prior_mean", "prior_deviation", "lower", "upper")
        return replace(
            self,
            parameters=tuple(self.parameters[k] for k in kept),
            constants={**self.constants, **values},
            **{name: getattr(self, name)[kept] for name in arrays},
        )
