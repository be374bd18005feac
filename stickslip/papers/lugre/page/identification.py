"""The identification: experiments, and prior knowledge."""

from collections.abc import Mapping
from functools import partial

from stickslip.identification.stages import friction_map, inertia
from stickslip.papers.lugre.page.curves import draw_friction, draw_inertia, draw_presliding
from stickslip.papers.lugre.page.section import section
from stickslip.papers.lugre.reproduction import Reproduction
from stickslip.presentation.markup import parts
from stickslip.presentation.page import Section
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
from stickslip.servo.axis import Datasheet

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


def identification_section(reproduction: Reproduction) -> Section:
    """Return the section on identification."""
    truth, sheet = reproduction.truth, Datasheet()
    estimates = [
        (
            symbol(name),
            meaning(name),
            parameter_estimate(name, estimate),
            percent(estimate.standard_error / abs(estimate.value), 2),
            parameter_value(name, truth[name]),
            parameter_unit(name),
        )
        for name, estimate in reproduction.identification.estimates.items()
    ]
    prior = [
        (
            label,
            number(factor * getattr(sheet, name)),
            number(factor * truth[drive]),
            unit(shown),
            source,
            parts.prose(use),
        )
        for name, (label, factor, shown, drive, source, use) in PRIOR.items()
    ]
    figures = {
        "identification_inertia": partial(draw_inertia, reproduction),
        "identification_friction": partial(draw_friction, reproduction),
        "identification_presliding": partial(draw_presliding, reproduction),
    }
    values = {"estimates": estimates, "prior": prior, "sliding": friction_map, "inertia": inertia}
    return section("Identification", "identification", reproduction, figures, **values)
