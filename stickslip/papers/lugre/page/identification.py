"""The identification: experiments, and prior knowledge."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from stickslip.identification.stages import friction_map, inertia
from stickslip.papers.lugre.page.curves import draw_friction, draw_inertia, draw_presliding
from stickslip.papers.lugre.reproduction import Reproduction
from stickslip.presentation.markup import Html, element, paragraph, prose, table
from stickslip.presentation.page import Illustration, Section
from stickslip.presentation.quantity import (
    meaning,
    number,
    parameter_estimate,
    parameter_unit,
    parameter_value,
    percent,
    symbol,
    unit,
)
from stickslip.servo.axis import LOOP, Datasheet


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
    return [
        element("h3", "Known before any experiment"),
        paragraph(
            "Identification and learning use measurements of the drive. They also use the "
            "numbers below, and the specification of the velocity loop (crossover "
            f"{number(LOOP.bandwidth)} Hz, phase margin {number(LOOP.phase_margin)}°, sample "
            f"period {number(1e3 * LOOP.T_s)} ms, low-pass {number(1e3 * LOOP.tau_f)} ms), which "
            "was calibrated (see Validation). Of Table 1 they use the peak force and the encoder’s "
            "step; the current, the winding and the force constant are not needed, because force "
            "is commanded and measured in N. The experiments are scaled for such a stage: "
            f"constant velocities from {number(1e3 * friction_map.SPEEDS[0])} to "
            f"{number(1e3 * friction_map.SPEEDS[-1])} mm/s along "
            f"{number(1e3 * friction_map.GUIDE)} mm of the guide, a force of "
            f"{number(inertia.FREQUENCY)} Hz."
        ),
        table(
            ("", "Assumed", "Simulated drive", "Unit", "Source", "Where it enters"),
            rows,
            "Prior knowledge of identification and learning",
            (0, 3, 4, 5),
        ),
    ]
