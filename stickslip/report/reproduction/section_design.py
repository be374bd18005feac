"""The velocity loop: Fig. 2 and the numbers of the design."""

from __future__ import annotations

from collections.abc import Mapping

from stickslip.pipeline.reproduction import Reproduction
from stickslip.report.markup import (
    Html,
    element,
    join,
    paragraph,
    symbol,
    table,
)
from stickslip.report.picture import Picture
from stickslip.report.quantity import number, unit
from stickslip.report.shown import figure


def write(reproduction: Reproduction, pictures: Mapping[str, Picture]) -> Html:
    """Return the section on the loop."""
    loop = reproduction.identification.loop
    margins = loop.margins()
    rows = [
        (symbol("m"), "identified inertia", number(loop.axis.m), "kg"),
        (symbol("b"), "identified viscous friction", number(loop.axis.b), unit("N.s/m")),
        (
            symbol("τ", "i"),
            "time constant of the current loop",
            number(1e3 * loop.axis.tau_i),
            "ms",
        ),
        (symbol("T", "s"), "sample period", number(1e3 * loop.T_s), "ms"),
        (symbol("τ", "f"), "low-pass of the velocity estimate", number(1e3 * loop.tau_f), "ms"),
        (symbol("K", "p"), "proportional gain", number(loop.K_p), unit("N.s/m")),
        (symbol("K", "i"), "integral gain", number(loop.K_i), "N/m"),
        ("crossover", "where the open loop’s gain is 1", number(margins["crossover_Hz"]), "Hz"),
        ("phase margin", "at the crossover", number(margins["phase_margin_deg"], 3), "°"),
        ("gain margin", "", number(margins["gain_margin_dB"], 3), "dB"),
        ("bandwidth", "closed loop, −3 dB", number(margins["bandwidth_Hz"], 3), "Hz"),
    ]

    return element(
        "section",
        element("h2", "The loop"),
        paragraph(
            "The velocity loop is a sampled PI controller. Its two gains follow from the crossover "
            "and the phase margin asked for, on the axis as identified. The nominal loop is the "
            "same loop without friction; its velocity ",
            symbol("v", "r"),
            " is what the compensated drive should show.",
        ),
        figure(
            pictures["fig2_loops"],
            "Block diagrams of the compensated loop and of the nominal loop, and a step response",
            join(
                [
                    "Fig. 2. (a) The loop with feedforward friction compensation. The compensating "
                    "force is called ",
                    symbol("F", "ff"),
                    " here; the paper calls it ",
                    symbol("F", "c"),
                    ", as it does Coulomb friction. (b) The nominal loop, to which (a) reduces "
                    "when friction is compensated. (c) Its response to a step of the command.",
                ]
            ),
        ),
        table(("", "", "Value", "Unit"), rows, "Design of the velocity loop", (0, 1, 3)),
    )
