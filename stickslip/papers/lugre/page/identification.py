"""The identification: experiments, prior knowledge, and the effect of errors in it."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from functools import partial
from textwrap import shorten
from typing import Any

import pandas as pd

from stickslip.identification.stages import inertia, sliding
from stickslip.papers.lugre.page.curves import draw_friction, draw_inertia, draw_presliding
from stickslip.papers.lugre.reproduction import Reproduction
from stickslip.presentation.markup import Html, element, paragraph, prose, quiet, table
from stickslip.presentation.page import Illustration, Section
from stickslip.presentation.quantity import (
    METRICS,
    meaning,
    number,
    parameter_estimate,
    parameter_unit,
    parameter_value,
    percent,
    symbol,
    unit,
)
from stickslip.servo.datasheet import LOOP, Datasheet


def identification_section(reproduction: Reproduction) -> Section:
    """Return the section on identification."""
    identification = reproduction.identification
    friction = identification.friction
    forward, back = (number(force, 3) for force in friction.breakaway)
    rows = [
        (
            symbol(name),
            meaning(name),
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
            "Stage 1. A strong, slow sine of force; the slope of force over acceleration is $m$.",
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
            "slowest points; the curve does not contain this effect.",
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
            "Three experiments on the simulated drive give coarse values of its parameters. "
            "Learning begins at these values and searches from 0.1 to 100 times each."
        ),
        figures,
        *(paragraph(f"{warning[:1].upper()}{warning[1:]}.") for warning in identification.warnings),
        table(
            ("", "", "Identified", "Standard error", "Simulated drive", "Unit"),
            rows,
            "Identified parameters (value ± standard error)",
            (0, 1, 5),
        ),
        *_prior_knowledge(reproduction),
    )


PRIOR: Mapping[str, tuple[str, float, str, str, str, str]] = {
    "mass": (
        *("moving mass", 1.0, "kg", "m", "assumed, near Table 2"),
        "not here: identification measures the mass. The commissioning loop of record mode",
    ),
    "peak_force": (
        *("peak force", 1.0, "N", "u_max", "Table 1"),
        f"stage 1 pushes with {percent(inertia.SHARE, 0)} of it; the break-away ramp of stage 2 "
        "ends at it",
    ),
    "tau_i": (
        *("current lag", 1e3, "ms", "tau_i", "assumed"),
        "design of the velocity loop, nominal loop, lead of the compensator",
    ),
    "encoder_step": (
        *("encoder step", 1e6, "µm", "encoder_step", "section 2.1"),
        "what counts as motion in stages 1 and 3; the velocity filter of record mode",
    ),
    "force_noise": (
        *("noise of the measured force", 1.0, "N", "noise_F", "assumed"),
        "not here: the velocity filter of record mode",
    ),
}
"""Each number of ``Datasheet``: name, factor from SI to a unit, that unit, the parameter of
drive.fmu that it is an assumption of, where it is from, and where it is used."""


def _prior_knowledge(reproduction: Reproduction) -> list[Html]:
    """Return the part of the page on prior knowledge."""
    sheet = Datasheet()
    rows = [
        (
            label,
            number(factor * getattr(sheet, name)),
            number(factor * reproduction.truth[drive]),
            unit(shown),
            source,
            prose(use),
        )
        for name, (label, factor, shown, drive, source, use) in PRIOR.items()
    ]
    parts = [
        element("h3", "Known before any experiment"),
        _table1(sheet),
        paragraph(
            "Identification and learning use measurements of the drive. They also use the "
            "numbers below, and the specification of the velocity loop (crossover "
            f"{number(LOOP.bandwidth)} Hz, phase margin {number(LOOP.phase_margin)}°, sample "
            f"period {number(1e3 * LOOP.T_s)} ms, low-pass {number(1e3 * LOOP.tau_f)} ms), which "
            "was calibrated (see Validation). The experiments are scaled for such a stage: "
            f"constant velocities from {number(1e3 * sliding.SPEEDS[0])} to "
            f"{number(1e3 * sliding.SPEEDS[-1])} mm/s along "
            f"{number(1e3 * sliding.GUIDE)} mm of the guide, a force of "
            f"{number(inertia.FREQUENCY)} Hz."
        ),
        table(
            ("", "Assumed", "Simulated drive", "Unit", "Source", "Where it enters"),
            rows,
            "Prior knowledge of identification and learning",
            (0, 3, 4, 5),
        ),
    ]
    if reproduction.beforehand is not None:
        parts += _variations(reproduction.beforehand)
    return parts


PEAK_CURRENT, RESISTANCE, INDUCTANCE, FORCE_CONSTANT = 9.0, 5.0, 2.8e-3, 23.0
"""What only Table 1 has: A, ohm, H, N/A_rms."""


def _table1(sheet: Datasheet) -> Html:
    electrical = number(1e3 * INDUCTANCE / RESISTANCE, 2)
    force = number(FORCE_CONSTANT * PEAK_CURRENT)
    rows = [
        (
            *("Peak force", number(sheet.peak_force), "N"),
            prose("limit of the simulated drive’s force; known to identification"),
        ),
        (
            *("Peak current", number(PEAK_CURRENT), "A"),
            prose(
                f"no use: the amplifier takes a force command. As an RMS value it gives {force} N "
                "with the force constant, which agrees with the peak force"
            ),
        ),
        (
            *("Electrical resistance", number(RESISTANCE), "Ω"),
            prose(f"no direct use. L/R = {electrical} ms is the time constant of the open circuit"),
        ),
        (
            *("Electrical inductance", number(1e3 * INDUCTANCE), "mH"),
            prose(
                f"no direct use. That the current follows within {number(1e3 * sheet.tau_i)} ms "
                "assumes a closed current loop, whose bandwidth the paper does not give"
            ),
        ),
        (
            *("Force constant", number(FORCE_CONSTANT), Html("N/A<sub>rms</sub>")),
            prose("no use: force is commanded and measured in N. It would scale a logged current"),
        ),
        (
            *("Encoder (section 2.1)", number(1e6 * sheet.encoder_step), "µm"),
            prose("steps of the simulated drive’s encoder; known to identification"),
        ),
    ]
    head = ("", "Value", "Unit", "Use here")
    return table(head, rows, "Table 1. Specifications of the real stage (paper)", (0, 2, 3))


REGIONS = ("start", "reverse")
VARIED = ("m", "b", "F_c")


def _variations(varied: pd.DataFrame) -> list[Html]:
    units = [f"{symbol(name)} [{parameter_unit(name)}]" for name in VARIED]
    reductions = [f"{region.capitalize()}: {', '.join(METRICS.values())}" for region in REGIONS]
    head = ("Assumed", *units, *reductions, "Velocity filter")
    rows = [_row(case) for case in varied.to_dict("records")]
    return [
        table(head, rows, "The same drive with an error in the prior knowledge"),
        quiet(
            "Identified values, and the reductions of Table 4 (measured) with the identified "
            "compensator, before any learning. “Velocity filter”: the least of the four reductions "
            "on the true velocity in the loop of record mode, with its velocity filter and "
            "feedforward of the inertia $m$. Rows that equal the first do not depend on that "
            "number."
        ),
    ]


def _row(case: Mapping[Hashable, Any]) -> tuple[str, ...]:
    label = "all as above"
    if case["quantity"] in PRIOR:
        name, factor, shown, *_ = PRIOR[case["quantity"]]
        assumed = f"{number(factor * case['value'])} {shown}"
        label = f"{name} × {number(case['factor'])} = {assumed}"
    if case["error"]:
        label = prose(f"{label}: {shorten(case['error'], 60, placeholder=' …')}")

    def cell(show: Callable[[float], str], *keys: str) -> str:
        if any(pd.isna(case[key]) for key in keys):
            return "–"
        return ", ".join(show(case[key]) for key in keys)

    return (
        label,
        *(cell(lambda found: number(found, 5), name) for name in VARIED),
        *(cell(percent, *(f"{region}_{metric}" for metric in METRICS)) for region in REGIONS),
        cell(percent, "filtered"),
    )
