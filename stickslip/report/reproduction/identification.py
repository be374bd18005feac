"""The identification: experiments, prior knowledge, and the effect of errors in it."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import pandas as pd

from stickslip.identification.stages import inertia, sliding
from stickslip.pipeline.reproduction import Reproduction
from stickslip.report.markup import (
    METRICS,
    Html,
    element,
    join,
    paragraph,
    parameter,
    parameter_estimate,
    parameter_unit,
    parameter_value,
    symbol,
    table,
)
from stickslip.report.page import Illustration, Section
from stickslip.report.quantity import MEANINGS, number, percent, unit
from stickslip.report.reproduction.experiments import draw_friction, draw_inertia, draw_presliding
from stickslip.servo.datasheet import LOOP, Datasheet


def identification_section(reproduction: Reproduction) -> Section:
    """Return the section on identification."""
    identification = reproduction.identification
    friction = identification.friction
    forward, back = (number(force, 3) for force in friction.breakaway)
    rows = [
        (
            parameter(name),
            MEANINGS[name],
            parameter_estimate(name, estimate),
            percent(estimate.standard_error / abs(estimate.value), 2),
            parameter_value(name, reproduction.truth[name]),
            parameter_unit(name),
        )
        for name, estimate in identification.estimates.items()
    ]
    figures = [
        Illustration(
            "identification_inertia",
            partial(draw_inertia, reproduction),
            "Motor force over acceleration, with the fitted line",
            join(
                [
                    "Stage 1. A strong, slow sine of force; the slope of force over acceleration "
                    "is ",
                    parameter("m"),
                    ".",
                ]
            ),
        ),
        Illustration(
            "identification_friction",
            partial(draw_friction, reproduction),
            "Friction force over velocity in both directions, with the fitted Stribeck curve",
            "Stage 2. Mean force at constant velocities, forth and back over the same positions, "
            "with standard errors (mostly smaller than the marks), and the break-away force: "
            f"{forward} N forward and {back} N back at a ramp of {number(friction.ramp_rate, 2)} "
            "N/s. A faster ramp breaks away later. Encoder steps make the velocity fluctuate by "
            f"{number(1e3 * friction.fluctuation, 2)} mm/s, which lowers the mean force of the "
            "slowest points; the curve is without it.",
        ),
        Illustration(
            "identification_presliding",
            partial(draw_presliding, reproduction),
            "Force steps, encoder position and fitted position over time",
            "Stage 3. Force steps below break-away bend the bristles; their stiffness and damping "
            "are fitted to the position that the encoder shows.",
        ),
    ]
    return Section(
        "Identification",
        paragraph(
            "Three experiments on the simulated drive find its parameters coarsely. Learning "
            "begins at these values and searches from 0.1 to 100 times each."
        ),
        figures,
        table(
            ("", "", "Identified", "Standard error", "Simulated drive", "Unit"),
            rows,
            "Identified parameters (value ± standard error)",
            (0, 1, 5),
        ),
        _prior_knowledge(reproduction),
    )


PEAK_CURRENT, RESISTANCE, INDUCTANCE, FORCE_CONSTANT = 9.0, 5.0, 2.8e-3, 23.0
"""What only Table 1 has: A, ohm, H, N/A_rms."""
REGIONS = ("start", "reverse")


@dataclass(frozen=True)
class Prior:
    """A number of ``setup.Datasheet`` as the page shows it.

    Attributes
    ----------
    factor, unit : from SI to what is shown
    drive : the parameter of drive.fmu that it is an assumption of
    source : where it is from
    enters : where it is used
    """

    label: str
    factor: float
    unit: str
    drive: str
    source: str
    enters: str


PRIOR: Mapping[str, Prior] = {
    "mass": Prior(
        "moving mass",
        1.0,
        "kg",
        "m",
        "assumed, near Table 2",
        "not here: identification measures the mass. The commissioning loop of record mode",
    ),
    "peak_force": Prior(
        "peak force",
        1.0,
        "N",
        "u_max",
        "Table 1",
        f"stage 1 pushes with {percent(inertia.SHARE, 0)} of it; the break-away ramp of stage 2 "
        "ends at it",
    ),
    "tau_i": Prior(
        "current lag",
        1e3,
        "ms",
        "tau_i",
        "assumed",
        "design of the velocity loop, nominal loop, lead of the compensator",
    ),
    "encoder_step": Prior(
        "encoder step",
        1e6,
        "µm",
        "encoder_step",
        "section 2.1",
        "what counts as motion in stages 1 and 3; the velocity filter of record mode",
    ),
    "force_noise": Prior(
        "noise of the measured force",
        1.0,
        "N",
        "noise_F",
        "assumed",
        "not here: the velocity filter of record mode",
    ),
}


def _prior_knowledge(reproduction: Reproduction) -> Html:
    """Return the part of the page on prior knowledge."""
    parts = [
        element("h3", "Known before any experiment"),
        _table1(),
        paragraph(
            "Identification and learning see the drive through its measurements. They also use the "
            "numbers below, and the specification of the velocity loop (crossover "
            f"{number(LOOP.bandwidth)} Hz, phase margin {number(LOOP.phase_margin)}°, sample "
            f"period {number(1e3 * LOOP.T_s)} ms, low-pass {number(1e3 * LOOP.tau_f)} ms), which "
            "was calibrated (see Validation). The experiments are scaled for such a stage: "
            f"constant velocities from {number(1e3 * sliding.SPEEDS[0])} to "
            f"{number(1e3 * sliding.SPEEDS[-1])} mm/s along "
            f"{number(1e3 * sliding.GUIDE)} mm of the guide, a force of "
            f"{number(inertia.FREQUENCY)} Hz."
        ),
        _prior(reproduction),
    ]
    if reproduction.beforehand is not None:
        parts.append(_variations(reproduction.beforehand))
    return join(parts, "\n")


def _table1() -> Html:
    sheet = Datasheet()
    electrical = number(1e3 * INDUCTANCE / RESISTANCE, 2)
    force = number(FORCE_CONSTANT * PEAK_CURRENT)
    rows = [
        (
            "Peak force",
            number(sheet.peak_force),
            "N",
            "limit of the simulated drive’s force; known to identification",
        ),
        (
            "Peak current",
            number(PEAK_CURRENT),
            "A",
            f"no use: the amplifier takes a force command. As an RMS value it gives {force} N with "
            "the force constant, which agrees with the peak force",
        ),
        (
            "Electrical resistance",
            number(RESISTANCE),
            "Ω",
            f"no direct use. L/R = {electrical} ms is the time constant of the open circuit",
        ),
        (
            "Electrical inductance",
            number(1e3 * INDUCTANCE),
            "mH",
            f"no direct use. That the current follows within {number(1e3 * sheet.tau_i)} ms "
            "assumes a closed current loop, whose bandwidth the paper does not give",
        ),
        (
            "Force constant",
            number(FORCE_CONSTANT),
            join(["N/A", element("sub", "rms")]),
            "no use: force is commanded and measured in N. It would scale a logged current",
        ),
        (
            "Encoder (section 2.1)",
            number(1e6 * sheet.encoder_step),
            "µm",
            "steps of the simulated drive’s encoder; known to identification",
        ),
    ]
    shown = [(*row[:3], element("span", row[3], class_="prose")) for row in rows]
    head = ("", "Value", "Unit", "Use here")
    return table(head, shown, "Table 1. Specifications of the real stage (paper)", (0, 2, 3))


def _prior(reproduction: Reproduction) -> Html:
    sheet = Datasheet()
    rows = [
        (
            known.label,
            number(known.factor * getattr(sheet, name)),
            number(known.factor * reproduction.truth[known.drive]),
            unit(known.unit),
            known.source,
            element("span", known.enters, class_="prose"),
        )
        for name, known in PRIOR.items()
    ]
    head = ("", "Assumed", "Simulated drive", "Unit", "Source", "Where it enters")
    return table(head, rows, "Prior knowledge of identification and learning", (0, 3, 4, 5))


def _variations(varied: pd.DataFrame) -> Html:
    rows = [_row(case) for case in varied.to_dict("records")]
    units = [join([parameter(name), f" [{parameter_unit(name)}]"]) for name in ("m", "b", "F_c")]
    metrics = join(METRICS.values(), ", ")
    reductions = [join([f"{region.capitalize()}: ", metrics]) for region in REGIONS]
    head = ("Assumed", *units, *reductions, "Velocity filter")
    return join(
        [
            table(head, rows, "The same drive with an error in the prior knowledge"),
            element(
                "p",
                "Identified values, and the reductions of Table 4 (measured) with the identified "
                "compensator, before any learning. “Velocity filter”: the least of the four "
                "reductions on the true velocity in the loop of record mode, with its velocity "
                "filter and feedforward of the inertia ",
                symbol("m"),
                ". Rows that equal the first do not depend on that number.",
                class_="quiet",
            ),
        ]
    )


def _row(case: Mapping[Hashable, Any]) -> tuple[str, ...]:
    known = PRIOR.get(case["quantity"])
    label = "all as above"
    if known:
        assumed = f"{number(known.factor * case['value'])} {known.unit}"
        label = f"{known.label} × {number(case['factor'])} = {assumed}"
    if case["error"]:
        label = element("span", f"{label}: {_first_words(case['error'])}", class_="prose")

    def cell(show: Callable[[float], str], *keys: str) -> str:
        if any(pd.isna(case[key]) for key in keys):
            return "–"
        return ", ".join(show(case[key]) for key in keys)

    return (
        label,
        *(cell(lambda found: number(found, 5), name) for name in ("m", "b", "F_c")),
        *(cell(percent, *(f"{region}_{metric}" for metric in METRICS)) for region in REGIONS),
        cell(percent, "filtered"),
    )


def _first_words(error: str, most: int = 60) -> str:
    """Return the beginning of an error, whole words."""
    if len(error) <= most:
        return error
    return error[: most + 1].rsplit(" ", 1)[0] + " …"
