"""The verdict on a log, which terminal, page and learned.json show first.

What was written, the error that it leaves, whether friction is the problem, what to check on the
machine, and what is uncertain.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from textwrap import wrap

import numpy as np
from matplotlib.figure import Figure

from stickslip.catalog.parameters import unit_of
from stickslip.compensators.entrants import parts
from stickslip.errors import with_settings
from stickslip.evaluation.tracking import FEEDFORWARD as WITH_FEEDFORWARD
from stickslip.evaluation.tracking import FRICTIONLESS, INERTIA, NONE, Tracking
from stickslip.identification.fitting.identifiability import NOT_IDENTIFIABLE
from stickslip.logs import UNSTATED, Motion
from stickslip.models.export.units import motion_unit
from stickslip.presentation import style
from stickslip.presentation.page import Section
from stickslip.presentation.quantity import SPACE, number
from stickslip.presentation.scale import WORDS, force_scale, position_scale, velocity_scale
from stickslip.studies.learn.learned import LearnedFromRecording
from stickslip.thresholds import control_match, offer
from stickslip.trial.benefit import Benefit
from stickslip.trial.observed import BOTH, FEEDFORWARD, OBSERVER, Choice

COMPENSATOR, OBSERVER_FMU = "compensator.fmu", "observer.fmu"
POSITION_FMU = "position_force.fmu"
MOST = 15  # lines on a terminal
LABEL = 12  # columns before their sentences


@dataclass(frozen=True)
class MotionError:
    """RMS error that friction causes in a motion, on simulated drives with the friction learned."""

    motion: str
    figure: str  # velocity, position or angle
    # on the median drive: without compensation and with what is written [m/s] or [m]
    without: float
    left: float
    # of these, between which the ratio of the true drive is expected
    low: float
    high: float

    @property
    def ratio(self) -> float:
        """Share of the error that is left."""
        return self.left / self.without


@dataclass(frozen=True)
class LoopShare:
    """RMS error along a command in one loop, and what of it is the loop's, not that of friction."""

    figure: str  # velocity or position
    unit: str  # of the errors
    where: str  # command and loop
    measured: float | None  # None where the log does not show it
    without: float
    compensated: float | None  # with the feedforward that is written, None for none
    frictionless: float
    remedy: str  # what would leave least of that in the loop; empty for nothing
    remedied: float

    @property
    def share(self) -> float:
        """Share of the error that stays without any friction."""
        return self.frictionless / self.without if self.without > 0.0 else math.nan

    @property
    def friction_matters(self) -> bool:
        """Whether the best compensator could leave less than what is worth its risk."""
        return not self.share > offer.GAIN

    @property
    def mismatch(self) -> str:
        """Why the simulated loop cannot be that of the log; empty where it can."""
        if not self.measured or not self.without:
            return ""
        factor = max(self.without / self.measured, self.measured / self.without)
        if factor <= control_match.ERRS_ALIKE:
            return ""
        return (
            f"the loop as described errs by {number(self.without, 3)} {self.unit} RMS in simulation"
            f" and by {number(self.measured, 3)} in the log; expected the same within a factor of"
            f" {control_match.ERRS_ALIKE:g}; check gains, feedforward, units and the limit of the"
            " force, or leave the controller out"
        )


@dataclass(frozen=True)
class Verdict:
    """What to take from a log, and how far to trust it."""

    source: str
    headline: str
    files: dict[str, str]  # what is written, by the name of the file
    refused: tuple[str, ...]  # what is not, or should not be used, and why
    errors: tuple[MotionError, ...]
    loop: LoopShare | None
    remedies: tuple[str, ...]  # what the loop needs
    checks: tuple[str, ...]
    doubts: tuple[str, ...]

    def __str__(self) -> str:
        rows = (f"{label:{LABEL}}{text}" for label, text in self.rows())
        return "\n".join([f"{self.source}: {self.headline}", *rows])

    def rows(self, folder: str = "") -> Iterator[tuple[str, str]]:
        """Yield a label and a sentence for each line; a folder precedes the names of files."""
        label = "use" if self.loop is None or self.loop.friction_matters else "optional"
        for k, (name, what) in enumerate(self.files.items()):
            yield "" if k else label, f"{folder}{name}: {what}"
        for line in self.refused:
            yield "warning", line
        if self.errors:
            yield "error left", _left(self.errors)
        if self.loop:
            yield "friction", _sentence(self.loop)
        for label, lines in (
            ("loop", self.remedies),
            ("check", self.checks),
            ("uncertain", self.doubts),
        ):
            for k, line in enumerate(lines):
                yield "" if k else label, line.replace(" learned.json", f" {folder}learned.json")


def verdict_of(
    learned: LearnedFromRecording,
    files: Sequence[str] | None = None,  # FMUs that are written; None for those that would be
    *,
    force: bool = False,
) -> Verdict:
    """Return the verdict on what was learned."""
    shown = learned.with_whole_force() if force else learned
    choice = shown.writes(force=force)
    motion = shown.estimation.recording.motion
    loop = loop_share(shown.tracking, motion, choice)
    files = file_names(learned) if files is None else files
    refused = tuple(refusals(learned, files, force=force))
    errors: tuple[MotionError, ...] = ()
    if files and shown.trial and choice == shown.choice and shown.trial.compared.chosen.benefit:
        errors = tuple(motion_errors(shown.trial.compared.chosen.benefit, motion))
    return Verdict(
        source=learned.estimation.recording.source,
        headline=_headline(learned, files, loop, force=force),
        files={name: _what(shown, name) for name in files},
        refused=refused,
        errors=errors,
        loop=loop,
        remedies=tuple(_remedies(shown, loop)),
        checks=tuple(_checks(shown, files)),
        doubts=tuple(_doubts(shown)),
    )


def file_names(learned: LearnedFromRecording, *, force: bool = False) -> tuple[str, ...]:
    """Return the names of the FMUs that are written."""
    choice = learned.writes(force=force)
    wanted = {
        COMPENSATOR: choice in (FEEDFORWARD, BOTH),
        OBSERVER_FMU: choice in (OBSERVER, BOTH),
        POSITION_FMU: learned.position_force and (force or not learned.doubt),
    }
    return tuple(name for name, is_written in wanted.items() if is_written)


def reasons(learned: LearnedFromRecording) -> dict[str, str]:
    """Return why FMUs should not be used, by their files; empty where there is no reason."""
    choice = learned.choice
    return {
        OBSERVER_FMU: learned.observer_refusal if choice in (OBSERVER, BOTH) else "",
        COMPENSATOR: learned.refusal if choice != OBSERVER else "",
        POSITION_FMU: learned.doubt if learned.position_force else "",
    }


def refusals(
    learned: LearnedFromRecording, files: Sequence[str], *, force: bool = False
) -> Iterator[str]:
    """Yield what is refused and why."""
    could = file_names(learned, force=True)
    told: dict[str, list[str]] = {}  # several files may have one reason
    for name, why in reasons(learned).items():
        how = "" if force or name not in could else " (<force> writes it)"
        fate = "written, as <force> asks for" if name in files else "not written"
        if why:
            told.setdefault(f"{fate}: {why}{how}", []).append(name)
    for said, names in told.items():
        yield with_settings(f"{' and '.join(names)} {'are' if names[1:] else 'is'} {said}")


def _headline(
    learned: LearnedFromRecording, files: Sequence[str], loop: LoopShare | None, *, force: bool
) -> str:
    compared = learned.trial and learned.trial.compared
    if loop and loop.mismatch and not files:
        return "no compensator is written: the loop as described is not that of the log"
    if loop and not loop.friction_matters and not loop.mismatch and _friction_shows(learned):
        stays = (
            f"{number(100 * loop.share, 3)} % of the {loop.figure} error stays without any friction"
        )
        if loop.share > 1.0:
            stays = f"without any the {loop.figure} error is {number(loop.share, 3)} times as large"
        start = f"on {_of(loop.where)} friction is not the problem: {stays}"
        if not files:
            return start
        gain = number(100 * max(1.0 - loop.share, 0.0), 2)
        return (
            f"{start}; what is written takes at most {gain} % of it; the rest is the loop's (below)"
        )
    if force and learned.writes() != learned.writes(force=True):
        return with_settings("what is written is not recommended, but asked for with <force>")
    if compared and learned.writes() and compared.chosen.benefit:
        levels = [row.level for row in compared.chosen.benefit.rows]
        return (
            f"friction is worth compensating: {compared.chosen.name} leaves"
            f" {number(100 * compared.chosen.mean, 2)} % of the error that it causes, in the mean"
            f" over motions on simulated drives with {min(levels):g} to {max(levels):g} times the"
            " friction"
        )
    if files:
        return "friction can be compensated; no compensator was tried"
    why = f": {compared.sentence}" if compared and not learned.refusal else ""
    return f"no compensator is written{why}"


def _of(place: str) -> str:
    """Return the command that a place of errors begins with."""
    return place.partition(",")[0]


def _friction_shows(learned: LearnedFromRecording) -> bool:
    """Return whether the log shows how large friction is."""
    F_c = learned.estimation.known.get("F_c")
    return F_c is not None and F_c.identifiability != NOT_IDENTIFIABLE


def _what(learned: LearnedFromRecording, name: str) -> str:
    """Return what a file is, and where its force is added."""
    if name == POSITION_FMU:
        return "gravity and cogging by position; add its force after the compensator"
    if name == OBSERVER_FMU:
        kind = learned.trial.compared.chosen.name.split("+")[-1] if learned.trial else ""
        place = ", to be added after the feedforward" if learned.choice == BOTH else ""
        return f"{_titled(kind, 'observer')}{place}"
    benefit = learned.benefit
    of = ""
    if benefit and benefit.why_less:
        of = f" at {number(100 * benefit.share)} % of the learned force, {benefit.why_less}"
    kind = learned.trial.compared.chosen.name.split("+")[0] if learned.trial else ""
    if kind in ("", "none") or learned.choice not in (FEEDFORWARD, BOTH):
        kind = learned.estimation.law.name
    return f"{_titled(kind, 'feedforward')}{of}"


def _titled(kind: str, otherwise: str) -> str:
    """Return the title of a compensator with its name in commands and files."""
    known = parts()
    return f"{known[kind].title} ({kind})" if kind in known else f"the {otherwise} {kind}".rstrip()


def motion_errors(benefit: Benefit, motion: Motion) -> Iterator[MotionError]:
    """Yield the errors of the median drive in each motion, with the friction of the log."""
    for one in benefit.motions:
        row = one.median
        if one.level == 1.0 and math.isfinite(row.ratio):
            figure = row.figure if row.figure == "velocity" else WORDS[motion][0]
            low, high = one.interval
            sizes = {"without": row.without, "left": row.compensated, "low": low, "high": high}
            yield MotionError(row.command, figure, **sizes)


def loop_share(tracking: Tracking | None, motion: Motion, choice: Choice) -> LoopShare | None:
    """Return what of the error along a command is the loop's."""
    if tracking is None:
        return None
    errors = tracking.errors()
    key = "position_rms" if tracking.by_position else "velocity_rms"
    size = {name: float(getattr(one, key)) for name, one in errors.items()}
    better = {name: float(getattr(one, key)) for name, one in tracking.remedies.items()}
    scale = (position_scale if tracking.by_position else velocity_scale)(motion, size[NONE])
    enough = max((1.0 - offer.GAIN) * size[FRICTIONLESS], min(better.values(), default=math.inf))
    remedy = next((name for name, left in better.items() if left <= enough), "")
    if remedy and better[remedy] > offer.GAIN * size[FRICTIONLESS]:
        remedy = ""
    compensated = choice in (FEEDFORWARD, BOTH)
    place = WORDS[motion][0] if tracking.by_position else "velocity"
    where = f"{tracking.command}, in a loop designed for the learned mass"
    if tracking.known:
        where = f"{tracking.command}, in its loop"
    return LoopShare(
        figure=place,
        unit=scale.unit,
        where=where,
        measured=(
            scale.factor * float(getattr(tracking.measured, key)) if tracking.measured else None
        ),
        without=scale.factor * size[NONE],
        compensated=scale.factor * size[WITH_FEEDFORWARD] if compensated else None,
        frictionless=scale.factor * size[FRICTIONLESS],
        remedy=remedy,
        remedied=scale.factor * better.get(remedy, math.nan),
    )


def _left(errors: Sequence[MotionError]) -> str:
    """Return the shares that are left, in the order of the motions."""
    found = []
    for figure in dict.fromkeys(one.figure for one in errors):
        own = [one for one in errors if one.figure == figure]
        shares = ", ".join(f"{one.motion} {number(100 * one.ratio, 2)} %" for one in own)
        low, high = min(one.low for one in own), max(one.high for one in own)
        found.append(
            f"{shares} of the {figure} error that friction causes; {number(100 * low, 2)} to"
            f" {number(100 * high, 2)} % are predicted for the true drive"
        )
        if worse := [one.motion for one in own if one.high > 1.0]:
            where = ", ".join(worse) if len(worse) < len(own) else "any motion"
            found[-1] += f", so it may get worse in {where}"
    return "; ".join(found)


def _sentence(loop: LoopShare) -> str:
    shown = [f"{number(loop.without, 3)} {loop.unit} without compensation"]
    if loop.measured is not None:
        shown[0] += f" (measured: {number(loop.measured, 3)})"
    if loop.compensated is not None:
        shown.append(f"{number(loop.compensated, 3)} with the feedforward alone")
    shown.append(f"{number(loop.frictionless, 3)} without any friction")
    return f"RMS {loop.figure} error, simulated: {', '.join(shown)}, on {loop.where}"


def _remedies(learned: LearnedFromRecording, loop: LoopShare | None) -> Iterator[str]:
    if loop and loop.mismatch:
        return
    if loop and loop.remedy:
        axis = learned.designed.compensated.axis
        mass, damping = (
            f"{number(x, 3)} {motion_unit(unit, rotary=axis.rotary)}"
            for x, unit in ((axis.m, "kg"), (axis.b, "N.s/m"))
        )
        of, search = "", ""
        if INERTIA in loop.remedy:
            of = f" ({mass}, {damping})"
            most = f"controller.m_ff=0:{2.0 * axis.m:.2g}"
            search = f"; 'stickslip tune learned.json --set-range {most}' searches that of the mass"
        yield (
            f"{loop.remedy}{of} would leave {number(loop.remedied, 3)} {loop.unit} of the loop's"
            f" {number(loop.frictionless, 3)} {loop.unit}{search}"
        )
    if learned.other_gains and learned.other_gains.error <= offer.OTHER_GAINS:
        yield learned.other_gains.sentence
    elif loop and not loop.friction_matters and not loop.remedy:
        yield "higher gains of the controller, or a slower command, reduce what friction does not"


def _checks(learned: LearnedFromRecording, files: Sequence[str]) -> Iterator[str]:
    motion = learned.estimation.recording.motion
    tracking = learned.tracking
    if COMPENSATOR in files and tracking and tracking.force > 0.0:
        scale = force_scale(motion, tracking.force)
        yield (
            "drive disabled: a slow positive velocity command must give a positive output; on"
            f" {_of(tracking.command)} it reaches {number(scale.factor * tracking.force, 3)}"
            f" {scale.unit.replace(SPACE, ' ')}"
        )
    if {COMPENSATOR, OBSERVER_FMU} & {*files}:
        yield (
            "raise the added force from 0 on a slow command; stop if the error grows or it swings"
        )


def _doubts(learned: LearnedFromRecording) -> Iterator[str]:
    estimation = learned.estimation
    check = estimation.controller  # whose gains confirm the units
    found = [
        f"{one.what}: {one.figure}, {_weighing(learned)}; {one.advice}"
        for one in learned.findings
        if one.what == UNSTATED and not (check and check.error <= control_match.NEAR)
    ]
    for one in estimation.faults:
        if one.what not in learned.doubt:
            told = ": ".join(filter(None, (one.what, one.figure.split(";")[0])))
            found.append(f"{told}; {one.advice}" if one.spoils == "values" else told)
    hidden = [n for n, one in estimation.known.items() if one.identifiability == NOT_IDENTIFIABLE]
    if hidden:
        show = f"stickslip plan --show {' '.join(hidden)}"
        found.append(f"{', '.join(hidden)}: not identifiable from this log; '{show}' plans one")
    found += learned.trial_warnings
    faults = {str(one) for one in estimation.faults}
    warnings = [
        one.what
        for one in learned.findings
        # what was learned tells better than the log what is identifiable
        if one.severity == "warning" and str(one) not in faults and "identifiable" not in one.what
    ]
    if warnings:
        found.append(f"warnings about the log: {'; '.join(warnings)}")
    yield from map(with_settings, found)


def _weighing(learned: LearnedFromRecording) -> str:
    """Return which mass or friction assumed units give, by which a wrong one is seen."""
    known, rotary = learned.estimation.known, learned.estimation.recording.rotary
    shown = [
        f"{name} = {number(known[name].value, 3)} {unit_of(name, rotary=rotary)}"
        for name in ("m", "F_c")
        if name in known
    ]
    return f"which gives {' and '.join(shown)}".replace(SPACE, " ")


def lines(verdict: Verdict, folder: Path | None, width: int | None) -> list[str]:
    """Return the verdict as lines of a terminal of a width, the last doubts left out if long."""
    more = f"{folder}/report.html shows all; " if folder else "--out DIR writes it and a page; "
    if folder and verdict.files:
        more += f"{folder}/deploy/steps.html tells how to deploy; "
    rows = [*verdict.rows(f"{folder or 'DIR'}/"), ("more", f"{more}-v prints the tables")]
    if not folder:
        rows = [("would write" if label == "use" else label, text) for label, text in rows]
    shown = [f"{verdict.source}: {verdict.headline}"]
    shown = wrap(shown[0], width) if width else shown
    for label, text in rows:
        parts = wrap(text, max(width - LABEL, 40), break_on_hyphens=False) if width else [text]
        heads = [label, *[""] * len(parts)]
        shown += [f"{head:{LABEL}}{part}" for head, part in zip(heads, parts, strict=False)]
    if len(shown) > MOST and len(verdict.doubts) > 1:
        return lines(replace(verdict, doubts=verdict.doubts[:-1]), folder, width)
    return shown


ERROR = "error"  # name of the figure


def verdict_section(verdict: Verdict, motion: Motion) -> Section:
    """Return the first section of the page."""
    figures = {ERROR: partial(draw_errors, verdict.errors, motion)} if verdict.errors else {}
    return Section(
        "",
        "studies/learn/page/verdict.j2",
        figures,
        verdict=verdict,
        shares=[
            (
                one.motion if one.figure == "velocity" else f"{one.motion}, {one.figure}",
                f"{number(100.0 * one.ratio, 2)} %",
                f"{number(100.0 * one.low, 2)} to {number(100.0 * one.high, 2)} % expected",
            )
            for one in verdict.errors
        ],
    )


def draw_errors(errors: Sequence[MotionError], motion: Motion) -> Figure:
    """Draw the error in each motion without and with what is written."""
    kinds = list(dict.fromkeys(one.figure for one in errors))
    rows = [[one for one in errors if one.figure == kind][::-1] for kind in kinds]
    figure = style.new_figure(style.PAGE, 22.0 + 8.0 * len(errors) + 10.0 * (len(kinds) - 1))
    panels = figure.subplots(len(kinds), 1, squeeze=False, height_ratios=list(map(len, rows)))[:, 0]
    for axes, kind, own in zip(panels, kinds, rows, strict=True):
        scale = (velocity_scale if kind == "velocity" else position_scale)(
            motion, max(one.without for one in own)
        )
        without, left, low, high = (
            scale.factor * np.array(each)
            for each in zip(
                *((o.without, o.left, o.low * o.without, o.high * o.without) for o in own),
                strict=True,
            )
        )
        places = np.arange(len(own))
        axes.hlines(places, low, high, color=style.WITH, lw=4.0, alpha=0.25, label="expected")
        axes.hlines(places, left, without, color=style.FAINT, lw=style.LINE, zorder=0)
        axes.plot(without, places, "o", color=style.WITHOUT, label="without compensation")
        axes.plot(left, places, "s", color=style.WITH, label="with what is written")
        axes.set(xscale="log", yticks=places, yticklabels=[one.motion for one in own])
        axes.set(
            xlabel=f"RMS {kind} error that friction causes [{scale.unit}]",
            ylim=(-0.6, len(own) - 0.4),
        )
        style.log_ticks(axes.xaxis, min(low.min(), left.min()), max(high.max(), without.max()))
    style.legend_below(panels[0])
    return figure
