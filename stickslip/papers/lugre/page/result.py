"""The head of the page: what was done, the result, and the errors at a glance."""

from __future__ import annotations

from stickslip import models
from stickslip.papers.lugre.page.loop_tuning import steps_at_a_glance
from stickslip.papers.lugre.reproduction import Reproduction
from stickslip.papers.lugre.steps import FILTERED, REDUCTION_WITH_FILTER
from stickslip.presentation.markup import Html, element, join, paragraph, tile
from stickslip.presentation.page import Section
from stickslip.presentation.quantity import (
    METRICS,
    number,
    percent,
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
    return Section("", done, *glance, _drive(reproduction), _verdict(reproduction))


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
    extras = reproduction.extras.table4 if reproduction.extras else None
    tiles = []
    for k, row in enumerate(own.to_dict("records")):
        beside = ["simulated drive", f"true velocity {percent(true['reduction'].iloc[k])}"]
        if FILTERED in true:
            reduced = true[REDUCTION_WITH_FILTER].iloc[k]
            beside.append(f"true velocity, with velocity filter {percent(reduced)}")
        if extras is not None:
            reduced = extras[extras["velocity"] == "measured"]["reduction"].iloc[k]
            beside.append(f"all extras on {percent(reduced)}")
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
        class_="verdict",
    )
