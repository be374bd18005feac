"""The velocity loop, and the use of the results."""

from __future__ import annotations

from functools import partial

from stickslip.papers.lugre.fmpy_check import SecondOpinion
from stickslip.papers.lugre.page.diagrams import draw_loops
from stickslip.papers.lugre.reproduction import Reproduction
from stickslip.presentation.markup import Html, element, paragraph, table
from stickslip.presentation.page import Illustration, Section, commands, file_list, made_with
from stickslip.presentation.quantity import number, unit


def design_section(reproduction: Reproduction) -> Section:
    """Return the section on the loop."""
    loop = reproduction.identification.loop
    margins = loop.margins()
    rows = [
        ("$m$", "identified inertia", number(loop.axis.m), "kg"),
        ("$b$", "identified viscous friction", number(loop.axis.b), unit("N.s/m")),
        (r"$\tau_i$", "time constant of the current loop", number(1e3 * loop.axis.tau_i), "ms"),
        ("$T_s$", "sample period", number(1e3 * loop.T_s), "ms"),
        (r"$\tau_f$", "low-pass of the velocity estimate", number(1e3 * loop.tau_f), "ms"),
        ("$K_p$", "proportional gain", number(loop.K_p), unit("N.s/m")),
        ("$K_i$", "integral gain", number(loop.K_i), "N/m"),
        ("crossover", "where the open loop’s gain is 1", number(margins["crossover_Hz"]), "Hz"),
        ("phase margin", "at the crossover", number(margins["phase_margin_deg"], 3), "°"),
        ("gain margin", "", number(margins["gain_margin_dB"], 3), "dB"),
        ("bandwidth", "closed loop, −3 dB", number(margins["bandwidth_Hz"], 3), "Hz"),
    ]
    return Section(
        "The loop",
        paragraph(
            "The velocity loop is a sampled PI controller. Its two gains follow from the crossover "
            "and the phase margin asked for, on the axis as identified. The nominal loop is the "
            "same loop without friction; its velocity $v_r$ is the target of the compensated drive."
        ),
        Illustration(
            "fig2_loops",
            partial(draw_loops, loop, reproduction.truth, reproduction.options),
            "Block diagrams of the compensated loop and of the nominal loop, and a step response",
            "Fig. 2 of the paper. (a) The loop with feedforward compensation. The compensating "
            "force is called $F_{ff}$ here; the paper calls it $F_c$, as it does Coulomb "
            "friction. (b) The nominal loop, to which (a) reduces when friction is compensated. "
            "(c) Its response to a step of the command.",
        ),
        table(("", "", "Value", "Unit"), rows, "Design of the velocity loop", (0, 1, 3)),
    )


def use_section(reproduction: Reproduction) -> Section:
    """Return the last section."""
    F_c, best = reproduction.refinement.values["F_c"], reproduction.loops.best.tuned
    files = {
        "learned_loop.ssp": "the learned loop, for any tool that opens SSP: use this one",
        "compensator.fmu, loop.ssp": "the same for the paper's own loop, with the whole force",
        "learned.json": "friction and both loops with units, cost, seed and versions",
        "loop_tuning.csv, fitness.csv": "what each step brings, and the searches",
        "table2.csv, table4.csv": "the tables of this page, unrounded",
    }
    if best.share:
        files["learned_compensator.fmu"] = "its feedforward, from the commands to the force"
    if best.observer.share:
        files["learned_observer.fmu"] = "its observer, from encoder and motor force to the force"
    if reproduction.motions:
        files["motions.csv"] = "errors of all motions, by region"
    if reproduction.extras and reproduction.extras.table4 is not None:
        files["table4_all_extras.csv"] = "Table 4 of the drive with all extras on"
    return Section(
        "Using the results",
        file_list(files),
        paragraph("Run the loop, run it with another parameter, and check the FMU:"),
        commands(
            "stickslip simulate learned_loop.ssp",
            f"stickslip simulate learned_loop.ssp --set compensator.F_c={F_c:.4g} --out run.csv",
            "stickslip check compensator.fmu",
        ),
        *([_fmu(reproduction.opinion)] if reproduction.opinion else []),
        made_with(),
    )


def _fmu(opinion: SecondOpinion) -> Html:
    """Return the comparison of the runs."""
    comparisons = opinion.comparisons
    different = sum(comparison.different for comparison in comparisons.values())
    samples = number(sum(comparison.samples for comparison in comparisons.values()), 7)
    verdict = f"All {samples} samples of its force are the same bit for bit."
    if different:
        largest = number(max(comparison.largest for comparison in comparisons.values()), 3)
        verdict = (
            f"{number(different, 7)} of {samples} samples of its force differ, by at most "
            f"{largest} N."
        )
    return paragraph(
        f"{opinion.tool} also ran compensator.fmu alone (",
        element("code", "simulate_fmu"),
        f") over the commands of the training and of the validation run of the loop. {verdict}",
    )
