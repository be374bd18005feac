"""The head of the page: what was done, the result, and the errors at a glance."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import pandas as pd

from stickslip import models
from stickslip.evaluation.validation import Validation
from stickslip.papers.lugre.page.loop_tuning import steps_at_a_glance
from stickslip.papers.lugre.reproduction import Extras, Reproduction
from stickslip.papers.lugre.steps import FILTERED, REDUCTION_WITH_FILTER
from stickslip.presentation.markup import Html, element, join, paragraph, quiet, table, tile
from stickslip.presentation.page import Section
from stickslip.presentation.quantity import (
    METRICS,
    number,
    parameter_estimate,
    parameter_unit,
    parameter_value,
    percent,
    ranged,
    unit,
)
from stickslip.servo.systems import drive_law

EFFECTS = {
    "current_loop": "lag of the current loop",
    "dac": "steps of the force command",
    "encoder": "steps of the encoder",
    "asymmetric": "asymmetric friction",
    "position_dependent": "position-dependent friction",
    "ripple": "force ripple",
    "noise": "measurement noise",
}
FEEDS = {"nominal": "the nominal loop’s velocity", "command": "the velocity command"}


def head(reproduction: Reproduction) -> Section:
    """Return the paragraph of what was done, and the verdict."""
    options = reproduction.options
    search = reproduction.loops.best.algorithm
    done = paragraph(
        "This page reproduces “The Feedforward Friction Compensation of Linear Motor Using Genetic "
        "Learning Algorithm”. The paper measured a real stage; all that is computed here is of a "
        "simulated drive, built as an FMU. It was identified by three experiments; a velocity loop "
        "was designed on what they found; least squares fitted the friction to runs of the drive; "
        f"{search.title} then learned the loop, its gains and compensators together (preset "
        f"“{options.preset}”, {len(reproduction.loops.learned)} seeds from {options.seed}, "
        f"compensator input: {FEEDS[options.feed]}). Identification and learning used only "
        "commands and measurements of the drive; its true parameters and its true velocity are "
        "used to evaluate the result.",
    )
    glance = steps_at_a_glance(reproduction)
    return Section(
        "", done, *glance, _drive(reproduction), _verdict(reproduction), _headline(reproduction)
    )


def _drive(reproduction: Reproduction) -> Html:
    start, law = drive_law(reproduction.options.truth)
    model = models.load_model("drive", law)
    variables = {v.name: v for v in model.variables if v.role == "parameter"}
    changes = [
        f"{name} = {number(float(value), 6)} {unit(variables[name].unit or '1')}".strip()
        + f" (instead of {number(float(variables[name].start), 6)})"
        for name, value in start.items()
    ]
    if model.law is not None and law != "lugre":
        changes.insert(0, f"friction law = {model.law.title} (instead of LuGre)")
    text = f"changed for this run: {', '.join(changes)}" if changes else "the paper’s, Table 2"
    switches = {name: v for name, v in variables.items() if v.type == "boolean"}
    states = {
        state: ", ".join(
            EFFECTS.get(name, name) for name in switches if bool(reproduction.truth[name]) == state
        )
        for state in (True, False)
    }
    return paragraph(
        f"Parameters of the simulated drive: {text}. Effects switched on: "
        f"{states[True] or 'none'}; off: {states[False] or 'none'}.",
    )


def _verdict(reproduction: Reproduction) -> Html:
    table = reproduction.table4()
    own, true = (table[table["velocity"] == shown] for shown in ("measured", "true"))
    extras = reproduction.extras and reproduction.extras.validation
    tiles = []
    for k, row in enumerate(own.to_dict("records")):
        beside = ["simulated drive", f"true velocity {percent(true['reduction'].iloc[k])}"]
        if FILTERED in true:
            reduced = true[REDUCTION_WITH_FILTER].iloc[k]
            beside.append(f"true velocity, with velocity filter {percent(reduced)}")
        if extras:
            beside.append(f"all extras on {percent(_measured(extras)['reduction'].iloc[k])}")
        beside.append(f"real stage (paper) {percent(row['paper_reduction'], 0)}")
        name = f"Motion {row['region']}, {METRICS[row['metric']]}"
        tiles.append(tile(name, percent(row["reduction"]), *beside))
    above = int((own["reduction"] > own["paper_reduction"]).sum())
    text = f"by more than that of the real stage (paper) in {above} of {len(own)} measures"
    if above == len(own):
        text = "by more than that of the real stage (paper), in every measure"
    return element(
        "div",
        paragraph(
            "In the paper’s own loop, with the learned friction fed forward, compensation reduces "
            f"the tracking error of the simulated drive, as its encoder shows it, {text}."
        ),
        element("div", join(tiles, "\n"), class_="tiles"),
        _coulomb(reproduction),
        class_="verdict",
    )


def _coulomb(reproduction: Reproduction) -> Html:
    learned, truth = reproduction.refinement.estimates["F_c"], reproduction.truth["F_c"]
    unit = parameter_unit("F_c")
    return paragraph(
        f"Coulomb friction $F_c$: learned {parameter_estimate('F_c', learned)} {unit}, the "
        f"simulated drive’s is {parameter_value('F_c', truth)} {unit}, off by "
        f"{percent(abs(learned.value / truth - 1.0), 2)}.",
    )


def _headline(reproduction: Reproduction) -> Html:
    """Return the errors on the measured velocity, without and with compensation, as rows."""
    own, extras = _measured(reproduction.validation), reproduction.extras
    shown = [("real stage (paper)", "paper_", own), ("simulated drive", "", own)]
    if extras and extras.validation:
        shown.append(("simulated drive, all extras on", "", _measured(extras.validation)))
    rows: list[tuple[str, ...]] = []
    for quantity in ("without", "with", "reduction"):
        name = "Reduction" if quantity == "reduction" else f"{quantity.capitalize()} compensation"
        for k, (drive, prefix, errors) in enumerate(shown):
            # Changed, the drive is no longer the one that was calibrated.
            if k == 1 and quantity == "without" and not reproduction.options.truth:
                drive += ", calibrated to this row"
            show: Callable[[float], str] = "{:.2f}".format
            if quantity == "reduction":
                show = partial(percent, digits=0 if prefix else 1)
            found = errors.to_dict("records")
            cells = [ranged(row, f"{prefix}{quantity}", show) for row in found]
            rows.append(("" if k else name, drive, *cells))
    head = [f"{region.capitalize()}, {METRICS[metric]}" for region, metric in own.index]
    caption = (
        "Velocity errors [mm/s] at motion start and reversal, as the encoder shows them: medians "
        "over phases of an encoder step, and ranges"
    )
    return join([table(("", "", *head), rows, caption, (0, 1)), _extras_remark(extras)])


def _extras_remark(extras: Extras | None) -> Html:
    if extras is None:
        return Html("")
    if extras.validation is None:
        return paragraph(f"With all extras on the drive could not be learned: {extras.reason}.")
    return quiet(
        "“All extras on” is the same drive with every effect of its model: identified, learned and "
        "validated from the beginning, with the same settings.",
    )


def _measured(validation: Validation) -> pd.DataFrame:
    errors = validation.table()
    return errors[errors["velocity"] == "measured"].set_index(["region", "metric"])
