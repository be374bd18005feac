"""The page on one recording: what was learned, how, how well, and how to use it."""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from pathlib import Path

from matplotlib.figure import Figure

from stickslip.fmi.files import atomic_write
from stickslip.identification.criteria.known_loop import OutputError, is_running
from stickslip.identification.estimation import Estimation
from stickslip.identification.fitting.identifiability import IDENTIFIABLE, LEVELS
from stickslip.logs import Finding
from stickslip.presentation.page import Section, picture_files, write_page
from stickslip.presentation.quantity import percentage
from stickslip.presentation.scale import WORDS, force_scale
from stickslip.studies.learn import tables
from stickslip.studies.learn.page import figures
from stickslip.studies.learn.page.signals import measures_friction, simulated_position, steady_name
from stickslip.thresholds import control_match, harm, offer
from stickslip.trial.compensator_trial import SimulatedTrial

FIGURES = ("recording", "force", "residual", "profiles")
FILES = ("parameters.csv", "report.html", *picture_files(FIGURES))
"""What ``write_estimation_report`` writes."""
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
LONGEST = 300  # log [s] of which an experiment of twice the duration is proposed
MEANINGS = {
    "parameters.csv": "the parameters with units and intervals, unrounded, in SI units",
    "learned.json": "the same with criterion, relative errors, seed and versions",
    "compensator.fmu": "the compensator, from the controller's commands to the force to add",
    "observer.fmu": "the disturbance observer, to be added after the compensator",
    "position_force.fmu": "gravity and cogging, from the position to the force to add: after the "
    "compensator and before the observer",
    "deploy": "the same as C and for PLCs behind one call; steps.html tells how to put it to work",
}


def _section(
    estimation: Estimation,
    title: str,
    template: str,
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


def sections(
    estimation: Estimation,
    findings: Sequence[Finding],  # of reading and checking the log
    beside: Sequence[str],  # names of the files in the page's folder
    # sections that follow that of the parameters, and that precede it
    further: Sequence[Section] = (),
    opening: Sequence[Section] = (),
    *,
    forced: bool = False,  # whether the compensator is written whatever its trial was
) -> list[Section]:
    """Return the sections of the page."""
    section, motion = partial(_section, estimation), estimation.recording.motion
    check = estimation.controller
    learned = section(
        "Learned parameters",
        "learned",
        errors=[(*one, "relative error") for one in _errors(estimation, ERRORS)],
        unit=force_scale(motion, 1.0).unit,
        LEVELS=LEVELS,
        HELD=tables.HELD,
    )
    criterion = section(
        "How candidates were evaluated",
        "criterion",
        loop=estimation.criterion == OutputError.name,
        running=check is not None and is_running(check.gains),
        errors=_errors(estimation, MEANT),
    )
    found = tables.findings(estimation, findings)
    fit = section(
        "The learned drive against the recording",
        "fit",
        {"force": figures.draw_force, "residual": figures.draw_residual},
        steady=steady_name(estimation),
        simulated=simulated_position(estimation) is not None,
    )
    identifiability = section(
        "How well each parameter is identified",
        "identifiability",
        {"profiles": figures.draw_profiles},
        unresolved=figures.unresolved(estimation),
    )
    tried = bool(estimation.held_out.predictions)
    return [
        *opening,
        section("", "head"),
        learned,
        *further,
        *([section("Which friction law explains the log", "laws")] if tried else []),
        criterion,
        section("The recording", "log", {"recording": figures.draw_recording}, findings=found),
        fit,
        identifiability,
        use(estimation, beside, forced=forced),
    ]


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


def use(estimation: Estimation, beside: Collection[str], *, forced: bool = False) -> Section:
    """Return the last section; parameters are those of ``sections``."""
    exports, force = [], " --force" if forced else ""
    if "compensator.fmu" in beside and "learned.json" in beside:
        exports += [
            f"stickslip export compensator --parameters learned.json --as {form}{force}"
            for form in ("fmu", "st")
        ]
    for part in ("observer", "position_force"):
        if f"{part}.fmu" in beside:
            exports.append(f"stickslip export {part} --parameters learned.json --as st{force}")
    if "compensator.fmu" in beside:
        exports.append("stickslip check compensator.fmu")
    files = {name: what for name, what in MEANINGS.items() if name in beside}
    known = estimation.known.items()
    vague = [name for name, one in known if one.identifiability != IDENTIFIABLE]
    check, blocks = estimation.controller, {"compensator.fmu", "observer.fmu"} & {*beside}
    known_loop = check is not None and check.error <= control_match.EXACT
    tunes = known_loop and bool(blocks) and "learned.json" in beside
    recorded = estimation.recording.t[-1] - estimation.recording.t[0]
    longer = 2 * min(math.ceil(recorded), LONGEST)
    values: dict[str, object] = {"files": files, "exports": exports, "vague": vague, "tunes": tunes}
    return _section(estimation, "Using the result", "use", None, longer=longer, **values)


def compensation(trial: SimulatedTrial) -> Section:
    """Return the section with what each compensator leaves of the error, and what is chosen."""
    compared, chosen = trial.compared, trial.compared.chosen
    return Section(
        "Whether compensation helps",
        "studies/learn/page/compensation.j2",
        chosen=chosen,
        compared=compared,
        own=trial.own,
        tried=list(tables.errors(chosen.benefit)) if chosen.benefit else [],
        relative=tables.compensators(compared),
        rule=harm.rule(),
        GAIN=offer.GAIN,
        LIMIT=offer.SENSITIVITY,
    )


def write_estimation_report(
    estimation: Estimation,
    findings: Sequence[Finding],
    folder: Path,
    further: Sequence[Section] = (),
    opening: Sequence[Section] = (),
    *,
    forced: bool = False,
) -> list[Path]:
    """Write parameters.csv, each figure as PNG and SVG, and report.html."""
    table = tables.parameters(estimation).frame().to_csv(index=False, lineterminator="\n")
    written = [atomic_write(folder / "parameters.csv", table)]
    beside = [path.name for path in folder.iterdir()]
    title = f"Friction of a drive, learned from {estimation.recording.source}"
    found = sections(estimation, findings, beside, further, opening=opening, forced=forced)
    return written + write_page(folder, title, found)
