"""What is deployed: the blocks of a learned.json behind one call, and a page of steps."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, get_args

from stickslip.errors import HarmfulError
from stickslip.learned.file import LearnedFile
from stickslip.learned.provenance import loop_doubts, provenance
from stickslip.models import Model, build_fmu, load_model
from stickslip.models.export.units import motion_unit
from stickslip.models.firmware import Language, write_combined
from stickslip.models.firmware.combined import ADDED_FORCE, SIGNALS, used_signals
from stickslip.presentation.page import Section, write_page
from stickslip.presentation.quantity import number
from stickslip.servo.systems import Compensator
from stickslip.thresholds import harm

FOLDER, PAGE = "deploy", "steps.html"
PARTS = ("compensator", "position_force", "observer")  # in the order of their calls
FILES = (
    f"{FOLDER}/{PAGE}",
    *(f"{FOLDER}/{part}.{end}" for part in (*PARTS, ADDED_FORCE) for end in ("c", "h")),
    *(f"{FOLDER}/{ADDED_FORCE}.{end}" for end in ("st", "xml")),
)
"""What ``write_deployment`` may write, in the folder of results."""


def deployed_parts(learned: LearnedFile) -> dict[str, Compensator]:
    """Return what was written as FMUs, by name, in the order of the calls."""
    return {
        part: learned.deployed(learned.share) if part == "compensator" else getattr(learned, part)
        for part in PARTS
        if f"{part}.fmu" in learned.written
    }


def build_parts(learned: LearnedFile, folder: Path, refusals: Mapping[str, str] = {}) -> None:
    """Build the FMUs of what is deployed; each says where its values come from, or why not to.

    Raises UsageError, StartValueError or UnknownModel when an entry of the file is not valid, or
    OSError.
    """
    for part, one in deployed_parts(learned).items():
        share = learned.share if part == "compensator" else None
        build_fmu(
            one.model,
            folder,
            start=one.values,
            law=_law(learned, one),
            called=part,
            rotary=learned.rotary,
            note=refusals.get(part, ""),
            notes=provenance(learned, share, f"{part}.fmu"),
        )


def _law(learned: LearnedFile, one: Compensator) -> str | None:
    return (one.law or learned.law.name) if load_model(one.model).law else None


def deployed_blocks(learned: LearnedFile) -> Iterator[Model]:
    """Yield the models of what was written as FMUs, with the same values, in the same order."""
    for part, one in deployed_parts(learned).items():
        model = load_model(one.model, _law(learned, one))
        yield replace(model.with_start(one.values), name=part)


def write_deployment(learned: LearnedFile, folder: Path) -> list[Path]:
    """Write the blocks behind one call, in each language, and the page; return the paths.

    Raises HarmfulError when learning wrote no compensator, UsageError, StartValueError or
    UnknownModel when an entry of the file is not valid, or OSError.
    """
    blocks = list(deployed_blocks(learned)) if "written" in learned.document else []
    if not blocks:
        refusal = learned.refusal or "it does not state which compensators learn wrote"
        raise HarmfulError(f"{learned.path}: nothing to deploy: {refusal}")
    names, rotary = [block.name for block in blocks], learned.rotary
    notes = provenance(learned, learned.share if "compensator" in names else None)
    paths: list[Path] = []
    for language in get_args(Language):
        paths += write_combined(folder, language, blocks, rotary=rotary, notes=notes)
    of_drive, loop = partial(motion_unit, rotary=rotary), learned.loop
    taken = {"x_cmd": loop.K_x, "a_cmd": loop.m_ff} if loop else {}
    signals = {name: one for name, one in used_signals(blocks).items() if taken.get(name, True)}
    verdict = {"source": "", "refused": (), **learned.mapping("verdict")}
    tuning = learned.mapping("tuning")
    section = Section(
        "",
        "learned/deploy.j2",
        signals=[(n, of_drive(u), text) for n, (u, text) in signals.items()],
        given=", ".join(name if name in signals else "0.0" for name in SIGNALS),
        assigned=", ".join(f"{name} := {name}" for name in signals),
        force_unit=of_drive("N"),
        T_s=learned.mapping("T_s").get("value"),
        names=names,
        verdict=verdict,
        warnings=dict.fromkeys([*verdict["refused"], *loop_doubts(learned)]),
        force_limit=learned.datasheet.peak_force if "datasheet" in learned.document else None,
        reserve=float(harm.LIMIT),
        gains_before=_gains(tuning, "before"),
        steps=list(_steps(names, [*signals], verdict, tuning)),
    )
    return paths + write_page(folder, "How to deploy the compensator", [section], PAGE)


def _steps(
    names: Sequence[str],
    signals: Sequence[str],
    verdict: Mapping[str, Any],
    tuning: Mapping[str, Any],
) -> Iterator[tuple[str, str, str]]:
    """Yield what to do, what must be seen, and what to do if it is not."""
    checks = list(verdict.get("checks", ()))
    seen = "the output valid is true (in C: the call returns true); F is not added yet"
    if "x_enc" in signals:
        seen += "; x_enc grows while the axis moves to positive positions"
    if "F_m" in signals:
        seen += "; F_m, in the mean of a motion, is greater forth than back"
    repair = "correct signs, units and zeros of the signals"
    yield "move the axis slowly forth and back by its controller alone", seen, repair
    if before := _gains(tuning, "before"):
        back = f"the gains as before: {before}"
        yield (
            f"enter the tuned gains in the controller: {_gains(tuning, 'after')}",
            "the same slow motion without oscillation or noise; F is not added yet",
            f"{back}; do not use this code then, which is tuned for the new gains",
        )
    if "compensator" in names:
        known = [one.partition(": ")[2] for one in checks if one.startswith("drive disabled: ")]
        output = known or ["a slow positive velocity command must give a positive output"]
        where = "F_ff of the compensator (in C: added.compensator.outputs.F_ff), not F of the call"
        seen = f"{where}: {output[0]}"
        yield "disable the drive and give commands", seen, repair
    if "position_force" in names:
        yield (
            "hold the axis at rest by its controller alone, at several positions",
            "F of position_force differs from the force of the motor by no more than the static"
            " friction",
            "the zero of x_enc must be that of the log; correct it, or the sign of the force",
        )
        yield (
            "where F is added while the axis is held: reduce the integral of the controller by F",
            "the axis does not jump",
            "stop",
        )
    raising = [one for one in checks if not one.startswith("drive disabled: ")]
    yield (
        (raising or ["raise the added force from 0 on a slow command"])[0],
        f"on a motion of {_slow(verdict)} with a gain of 0.25, 0.5 and 1 the RMS error of the"
        " velocity becomes smaller each time. In creep it may grow before the gain is 1, and in"
        " fast motions by what friction hid of the lag of the loop",
        "gain 0; compare period, signs and units with those above",
    )
    if found := [one for one in tuning.get("ratios", ()) if one["of"] == "RMS"]:
        left = "; ".join(
            f"{one['motion']}, {one['figure']}: {number(100.0 * one['ratio'], 2)} %"
            for one in found
        )
        yield (
            "run the motions of the machine",
            f"predicted RMS error, of that with the gains before and what was added then: {left}",
            f"gain 0, and {back}" if before else "gain 0",
        )
    elif errors := verdict.get("errors"):
        left = "; ".join(
            f"{one['motion']}, {one['figure']}: {number(100.0 * one['left'] / one['without'], 2)} %"
            f" ({number(100.0 * one['low'], 2)} to {number(100.0 * one['high'], 2)} %)"
            for one in errors
        )
        yield (
            "run the motions of the machine",
            "the RMS error of slow motions is smaller than without the added force. Of the error"
            " that friction causes, which is that beyond a run without friction, such as a"
            f" simulation, this is predicted to be left: {left}",
            "record a log with the added force and one without it, and compare them as"
            " docs/results.md says, with ../learned.json",
        )


def _slow(verdict: Mapping[str, Any]) -> str:
    """Return the speed of the slowest motion that was tried at a stated speed."""
    found = [one["motion"] for one in verdict.get("errors", ()) if one["motion"][0].isdigit()]
    return found[-1] if found else "a tenth of the usual speed"


def _gains(tuning: Mapping[str, Any], when: str) -> str:
    """Return the gains of the controller that were tuned, before or after, in words."""
    shown = {
        one["parameter"]: [f"{number(one[at])} {one['unit']}" for at in ("before", "after")]
        for one in tuning.get("parameters", ())
    }
    return ", ".join(
        f"{name.removeprefix('controller.')} = {ends[when == 'after']}"
        for name, ends in shown.items()
        if name.startswith("controller.") and ends[0] != ends[1]
    )
