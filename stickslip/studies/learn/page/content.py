"""Sections on what one recording gave: parameters, evaluation, fit, compensation, and use."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from functools import partial

import numpy as np
from matplotlib.figure import Figure

from stickslip.identification.criteria.known_loop import OutputError, is_running
from stickslip.identification.estimation import Estimation
from stickslip.identification.fitting.identifiability import IDENTIFIABLE, LEVELS
from stickslip.logs import Finding
from stickslip.presentation.page import Section
from stickslip.presentation.quantity import percentage
from stickslip.presentation.scale import WORDS, force_scale, velocity_scale
from stickslip.studies.learn import tables
from stickslip.studies.learn.page.figures import (
    draw_correlations,
    draw_force,
    draw_profiles,
    draw_recording,
    draw_residual,
    unresolved,
)
from stickslip.studies.learn.page.signals import (
    measures_friction,
    residual,
    simulated_position,
    steady_name,
)
from stickslip.studies.learn.page.stretches import stretches
from stickslip.thresholds import control_match, harm, offer
from stickslip.trial.candidates import CompensatorComparison

ERRORS = {
    "force": "{0} predicted from the motion",
    "position": "{1}, loop simulated",
    "velocity": "Velocity, loop simulated",
    "closed_loop_force": "{0}, loop simulated",
}
MEANT = {
    "force": "{0}, recorded against predicted from the recorded motion, both low-passed",
    "force_unfiltered": "The same, recorded signal as it is",
    "position": "{1}, recorded against simulated in the closed loop",
    "velocity": "Velocity, differences of the same signals",
    "closed_loop_force": "{0}, recorded against commanded in the simulated loop",
}
STANDING_OUT = 5  # Stretches of the residual that are named


def _section(
    title: str,
    template: str,
    estimation: Estimation,
    draw: Mapping[str, Callable[[Estimation], Figure]] | None = None,
    **values: object,
) -> Section:
    """Return a section with figures, by their names."""
    place, push = WORDS[estimation.recording.motion]
    return Section(
        title,
        f"studies/learn/page/{template}.j2",
        {name: partial(one, estimation) for name, one in (draw or {}).items()},
        estimation=estimation,
        tables=tables,
        place=place,
        push=push,
        measures_friction=measures_friction(estimation),
        **values,
    )


def head(estimation: Estimation) -> Section:
    """Return the head of the page: of which recording what was learned."""
    return _section("", "head", estimation)


def learned(estimation: Estimation) -> Section:
    """Return what was learned: verdict, relative errors, and the table of parameters."""
    unit = force_scale(estimation.recording.motion, np.ones(1)).unit
    errors = [(*one, "relative error") for one in _errors(estimation, ERRORS)]
    title = "Learned parameters"
    return _section(title, "learned", estimation, errors=errors, unit=unit, LEVELS=LEVELS)


def _errors(estimation: Estimation, names: dict[str, str]) -> list[tuple[str, str]]:
    """Return what the names of relative errors mean, and the errors that are known."""
    place, push = (word.capitalize() for word in WORDS[estimation.recording.motion])
    push = "Friction" if measures_friction(estimation) else push
    errors = estimation.figures.errors()
    return [
        (meant.format(push, place), percentage(errors[name]))
        for name, meant in names.items()
        if math.isfinite(errors[name])
    ]


def compensation(compared: CompensatorComparison) -> Section:
    """Return the section with what each compensator leaves of the error, and what is chosen."""
    chosen = compared.chosen
    return Section(
        "Whether compensation helps",
        "studies/learn/page/compensation.j2",
        chosen=chosen,
        compared=compared,
        tried=list(tables.errors(chosen.benefit)) if chosen.benefit else [],
        relative=tables.compensators(compared),
        WORSE=harm.WORSE,
        DRIVES=harm.DRIVES,
        SCATTER=harm.SCATTER,
        GAIN=offer.GAIN,
        LIMIT=offer.SENSITIVITY,
    )


FILES = {
    "parameters.csv": "the parameters with units and intervals, unrounded, in SI units",
    "learned.json": "the same with criterion, relative errors, seed and versions",
    "compensator.fmu": "the tuned compensator, from the controller's commands to the force to add",
    "observer.fmu": "the disturbance observer, to be added after the compensator",
}


def use(estimation: Estimation, beside: Collection[str], *, forced: bool = False) -> Section:
    """Return the last section.

    Parameters
    ----------
    beside : names of the files in the page's folder
    forced : whether what is refused was written
    """
    exports, force = [], " --force" if forced else ""
    if "compensator.fmu" in beside and "learned.json" in beside:
        exports += [
            f"stickslip export compensator --parameters learned.json --as {form}{force}"
            for form in ("fmu", "st")
        ]
    if "observer.fmu" in beside:
        exports.append(f"stickslip export observer --parameters learned.json --as st{force}")
    if "compensator.fmu" in beside:
        exports.append("stickslip check compensator.fmu")
    files = {name: what for name, what in FILES.items() if name in beside}
    known = estimation.known.items()
    vague = [name for name, one in known if one.identifiability != IDENTIFIABLE]
    title = "Using the result"
    check, blocks = estimation.controller, {"compensator.fmu", "observer.fmu"} & {*beside}
    known_loop = check is not None and check.error <= control_match.EXACT
    tunes = known_loop and bool(blocks) and "learned.json" in beside
    return _section(
        title, "use", estimation, files=files, exports=exports, vague=vague, tunes=tunes
    )


def criterion(estimation: Estimation) -> Section:
    """Return the section on the criterion, the errors and the search."""
    check = estimation.controller
    return _section(
        "How candidates were evaluated",
        "criterion",
        estimation,
        loop=estimation.criterion == OutputError.name,
        running=check is not None and is_running(check.gains),
        errors=_errors(estimation, MEANT),
    )


def laws(estimation: Estimation) -> Section:
    """Return the section with the force error of each law that was tried."""
    return _section("Which friction law explains the log", "laws", estimation)


def log(estimation: Estimation, findings: Collection[Finding]) -> Section:
    """Return the section on the log, errors and warnings first."""
    found = tables.findings(estimation, findings)
    draw = {"recording": draw_recording}
    return _section("The recording", "log", estimation, draw, findings=found)


def fit(estimation: Estimation) -> Section:
    """Return the section on the fit."""
    found = residual(estimation)
    return _section(
        "The learned drive against the recording",
        "fit",
        estimation,
        {"force": draw_force, "residual": draw_residual},
        steady=steady_name(estimation),
        simulated=simulated_position(estimation) is not None,
        outliers=stretches(found.t, found.values, found.velocity),
        most=STANDING_OUT,
        scale=found.scale,
        speeds=velocity_scale(estimation.recording.motion, found.velocity),
    )


def identifiability(estimation: Estimation) -> Section:
    """Return the section on how well the recording identifies each parameter."""
    title = "How well each parameter is identified"
    draw = {"profiles": draw_profiles, "correlations": draw_correlations}
    names = unresolved(estimation)
    return _section(title, "identifiability", estimation, draw, unresolved=names)
