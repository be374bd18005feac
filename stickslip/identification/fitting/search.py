"""The global search of friction parameters, and least squares from several starts."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from stickslip import ga
from stickslip.catalog.parameters import Values
from stickslip.identification.criteria.inverse_model import ForceCost, InverseModel
from stickslip.identification.criteria.runs import Criterion
from stickslip.identification.fitting.fit import BLOCKS, FTOL, Fit, fit
from stickslip.identification.fitting.identifiability import NOT_IDENTIFIABLE, identifiability
from stickslip.identification.fitting.start import Start
from stickslip.output import steps
from stickslip.servo.measurement import Array
from stickslip.thresholds import law_choice

EVALUATIONS = 300  # enough to reach the basin of the minimum; a local fit follows
PATIENCE = 100


def problem(start: Start) -> ga.Problem:
    """Return a gene for each parameter of the law between the bounds of the space."""
    space = start.space
    low, high = space.decode(space.lower), space.decode(space.upper)
    for name, bound in space.bounded.items():
        low[name] = low[bound]

    def gene(name: str) -> ga.Gene:
        one = space.law.parameters[name]
        linear, ends = one.coordinate == "linear", (low[name], high[name])
        return ga.Gene(name, *ends, start.line[name], unit=one.unit, linear=linear)

    genes = [gene(name) for name in space.friction]
    repairs = [ga.AtLeast(name, bound) for name, bound in space.bounded.items()]
    return ga.Problem(genes, repairs[0] if repairs else None)


@dataclass(frozen=True)
class Search:
    """How to search."""

    algorithm: str = "default"  # one of ``ga.ALGORITHMS``
    evaluations: int = EVALUATIONS  # at most
    # candidates side by side; also the runs of an experiment while what was found is fitted
    workers: int = 1


def search(
    model: InverseModel,
    start: Start,
    seed: int,
    how: Search,
    on_generation: Callable[[ga.Optimiser], object] | None = None,
) -> ga.Optimiser:
    """Search the parameters of the law whose predicted force is nearest to the measured one."""
    limits = ga.Limits(evaluations=how.evaluations, patience=PATIENCE)
    algorithm = ga.optimiser(how.algorithm, problem(start), limits, seed)
    cost = ForceCost(model, start.space.friction, start.line["delay"])
    ga.learn(algorithm, cost, on_generation=on_generation)
    return algorithm


def solve_linear(model: InverseModel, start: Start, friction: Array) -> dict[str, float]:
    """Return all values: those of the law, and the m, b and F_0 of linear least squares."""
    values = {**start.line, **dict(zip(start.space.friction, friction.tolist(), strict=True))}
    if model.measures_friction:
        return values
    slides = model.slides[model.used]
    rest = model.residual({**values, "m": 0.0, "b": 0.0, "F_0": 0.0})[slides]
    found, *_ = np.linalg.lstsq(model.linear[model.used][slides], rest, rcond=None)
    low = start.space.decode(start.space.lower)
    values["m"], values["b"] = max(float(found[0]), low["m"]), max(float(found[1]), 0.0)
    values["F_0"] = float(found[2])
    return values


STEEPER = 0.5
WIDER = 1.5  # ratio of v_s with the exponent 2 to that with 1, for the same friction
AMBIGUITY = 0.6  # standard error, as share of the distance of two fits, where neither is better


def best_fit(
    inverse: InverseModel, start: Start, values: Values, compared: Values | None = None
) -> Fit:
    """Fit from the result of a search, from a typical Stribeck curve there, and from the line.

    ``compared`` is a fit of the same law, from which it begins where there is one.

    A search ends now and then in a local minimum: of a curve that falls over the whole range
    of speeds, compensated by viscous friction; or, where the drive rests for long, of bristles
    that are too stiff to show.
    """
    known = ("m", "b", "F_0", "F_c", *inverse.space.rise)
    usual = {**values, **{name: start.line[name] for name in known if name in start.line}}
    if "v_s" in usual:
        usual["v_s"] *= STEEPER
    every = (compared, values, start.line, usual)
    starts = [inverse.space.encode(at) for at in every if at is not None]
    return fit(inverse, steps(starts))


def without_stribeck(criterion: Criterion, found: Fit) -> Fit:
    """Return a fit without a rise of friction towards rest, if the recording does not require one.

    A compensator would compensate a rise that no measurement shows, and a force
    that does not exist pushes the drive. A rise that spreads over all speeds is a part of b.
    """
    errors, space = found.errors(), found.space
    if not space.bounded or all(
        identifiability(name, found, errors, BLOCKS).identifiability != NOT_IDENTIFIABLE
        for name in space.rise
    ):
        return found
    q = found.q.copy()
    q[[space.index(name) for name in space.bounded]] = 0.0
    flat = fit(criterion.over(space.level()), [q])
    return flat if flat.noise < law_choice.RISE_WORTH * found.noise else found


def variants(criterion: Criterion, found: Fit, ftol: float = FTOL) -> list[Fit]:
    """Return a fit for each of the values to choose from, such as the exponents 1 and 2.

    The preferred one is the first. Where no Stribeck curve shows, ``found`` is the only one.
    """
    space, fits = found.space, [found]
    for name, parameter in space.law.parameters.items():
        is_constant = name in space.constants and parameter.choices
        if not is_constant or (parameter.requires and space.is_level):
            continue
        for choice in parameter.choices:
            change = choice - space.constants[name]
            if not change:
                continue
            q = found.q.copy()
            if parameter.requires and "v_s" in space.names:
                q[space.index("v_s")] += np.log(WIDER) * change
            fits.append(fit(criterion.over(space.fixed(**{name: choice})), [q], ftol))
        order = parameter.choices.index
        fits.sort(key=lambda one: order(one.space.constants[name]))
    return fits


@dataclass(frozen=True)
class Selection:
    """One of several fits of the same recording."""

    fit: Fit  # the selected one
    ambiguity: Array  # (k, k) covariance of its coordinates from not knowing which one is right


def select(fits: Sequence[Fit], sure: float | None = None) -> Selection:
    """Select the first fit, or the best of those that leave less than ``sure`` times its variance.

    Where neither of two fits is sure, the interval of 95 % contains both. With ``sure = 0`` the
    first fit is always selected, and is never sure.
    """
    first, sure = fits[0], law_choice.EXPONENT if sure is None else sure
    better = [one for one in fits[1:] if one.noise < sure * first.noise]
    best = min(better, key=lambda one: one.noise, default=first)
    ambiguity = np.zeros_like(best.covariance)
    for other in fits:
        is_alike = other.noise >= sure * best.noise and best.noise >= sure * other.noise
        if other is not best and is_alike and other.space.names == best.space.names:
            apart = AMBIGUITY * (other.q - best.q)
            ambiguity = ambiguity + np.outer(apart, apart)
    return Selection(best, ambiguity)
