"""The page's head: what was done and what came out."""

from __future__ import annotations

from collections.abc import Mapping

from stickslip import models
from stickslip.pipeline.reproduction import Reproduction
from stickslip.report.markup import (
    Html,
    element,
    join,
    paragraph,
)
from stickslip.report.picture import Picture
from stickslip.report.quantity import (
    number,
    percent,
    unit,
)
from stickslip.report.reproduction.headline import headline
from stickslip.report.shown import (
    METRICS,
    parameter,
    parameter_estimate,
    parameter_unit,
    parameter_value,
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


def write(reproduction: Reproduction, _: Mapping[str, Picture]) -> Html:
    """Return the paragraph of what was done, and the verdict."""
    options = reproduction.options
    algorithm = reproduction.algorithm
    done = paragraph(
        "This page reproduces “The Feedforward Friction Compensation of Linear Motor Using Genetic "
        "Learning Algorithm”. The paper measured a real stage; all that is computed here is of a "
        "simulated drive, built as an FMU. It was identified by three experiments; a "
        f"velocity loop was designed on what they found; {algorithm.title} then tried "
        f"{number(algorithm.evaluations, 6)} friction compensators on the drive "
        f"(preset “{options.preset}”, seed {options.seed}, compensator fed with "
        f"{FEEDS[options.feed]}){_refined(reproduction)}. Identification and learning saw the "
        "drive’s commands and measurements only; its true parameters and its true velocity serve "
        "to judge the result.",
    )
    parts = [done, _drive(reproduction), _verdict(reproduction), headline(reproduction)]
    return join(parts, "\n")


def _refined(reproduction: Reproduction) -> str:
    if not reproduction.options.refined:
        return ""
    if reproduction.learned.skipped:
        return "; no search followed this first generation, since the drive had no more to teach"
    if reproduction.learned.accepted:
        return ", and a least-squares fit refined the winner"
    return "; a least-squares fit of the winner did not do better and was not taken"


def _drive(reproduction: Reproduction) -> Html:
    start, law = drive_law(reproduction.options.truth)
    model = models.load_model("drive", law)
    variables = {v.name: v for v in model.variables if v.role == "parameter"}
    changes = [
        f"{name} = {number(float(value), 6)} {unit(variables[name].unit or '1')}".strip()
        + f" (instead of {number(float(variables[name].start), 6)})"
        for name, value in start.items()
    ]
    if model.law is not None and law is not None:
        changes.insert(0, f"friction law = {model.law.title} (instead of LuGre)")
    said = f"changed for this run: {', '.join(changes)}" if changes else "the paper’s, Table 2"
    switches = {name: v for name, v in variables.items() if v.type == "boolean"}
    states = {
        state: ", ".join(
            EFFECTS.get(name, name) for name in switches if bool(reproduction.truth[name]) == state
        )
        for state in (True, False)
    }
    return paragraph(
        f"Parameters of the simulated drive: {said}. Effects switched on: "
        f"{states[True] or 'none'}; off: {states[False] or 'none'}.",
    )


def _verdict(reproduction: Reproduction) -> Html:
    table = reproduction.validation.table()
    shown = {
        (row["velocity"], row["region"], row["metric"]): row for row in table.to_dict("records")
    }
    keys = [key[1:] for key in shown if key[0] == "measured"]
    extras = _extras(reproduction)
    tiles, above = [], 0
    for region, metric in keys:
        measured, true = (shown[velocity, region, metric] for velocity in ("measured", "true"))
        above += measured["reduction"] > measured["paper_reduction"]
        tiles.append(
            element(
                "div",
                element("span", f"Motion {region}, ", METRICS[metric], class_="name"),
                element("span", percent(measured["reduction"]), class_="value"),
                element("span", "simulated drive", class_="beside"),
                element("span", f"true velocity {percent(true['reduction'])}", class_="beside"),
                *extras.get((region, metric), ()),
                element(
                    "span",
                    f"real stage (paper) {percent(measured['paper_reduction'], 0)}",
                    class_="beside",
                ),
                class_="tile",
            )
        )
    if above == len(keys):
        said = "by more than that of the real stage (paper), in every measure"
    else:
        said = f"by more than that of the real stage (paper) in {above} of {len(keys)} measures"
    return element(
        "div",
        paragraph(
            "Compensation reduces the tracking error of the simulated drive, as its encoder shows "
            f"it, {said}."
        ),
        element("div", join(tiles, "\n"), class_="tiles"),
        _coulomb(reproduction),
        class_="verdict",
    )


def _extras(reproduction: Reproduction) -> dict[tuple[str, str], list[Html]]:
    """Return a line of each tile, where the drive with all extras was learned."""
    extras = reproduction.extras
    if extras is None or extras.validation is None:
        return {}
    return {
        (row["region"], row["metric"]): [
            element("span", f"all extras on {percent(row['reduction'])}", class_="beside")
        ]
        for row in extras.validation.table().to_dict("records")
        if row["velocity"] == "measured"
    }


def _coulomb(reproduction: Reproduction) -> Html:
    learned, truth = reproduction.learned.estimates["F_c"], reproduction.truth["F_c"]
    unit_ = parameter_unit("F_c")
    return paragraph(
        "Coulomb friction ",
        parameter("F_c"),
        f": learned {parameter_estimate('F_c', learned)} {unit_}, the simulated drive’s is "
        f"{parameter_value('F_c', truth)} {unit_}, off by "
        f"{percent(abs(learned.value / truth - 1.0), 2)}.",
    )
