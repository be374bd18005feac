"""The head of the page: what was done, the result, and the errors at a glance."""

from __future__ import annotations

from collections.abc import Callable

import pandas as pd

from stickslip import models
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
    table,
)
from stickslip.report.page import Section
from stickslip.report.quantity import number, percent, unit
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
    algorithm = reproduction.algorithm
    done = paragraph(
        "This page reproduces “The Feedforward Friction Compensation of Linear Motor Using Genetic "
        "Learning Algorithm”. The paper measured a real stage; all that is computed here is of a "
        "simulated drive, built as an FMU. It was identified by three experiments; a "
        f"velocity loop was designed on what they found; {algorithm.title} then tried "
        f"{number(algorithm.evaluations, 6)} friction compensators on the drive "
        f"(preset “{options.preset}”, seed {options.seed}, compensator input: "
        f"{FEEDS[options.feed]}){_refined(reproduction)}. Identification and learning saw the "
        "drive’s commands and measurements only; its true parameters and its true velocity are "
        "used to evaluate the result.",
    )
    return Section("", done, _drive(reproduction), _verdict(reproduction), _headline(reproduction))


def _refined(reproduction: Reproduction) -> str:
    if not reproduction.options.refined:
        return ""
    if reproduction.learned.skipped:
        return "; no search followed this first generation, since a search would gain nothing"
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
        text = "by more than that of the real stage (paper), in every measure"
    else:
        text = f"by more than that of the real stage (paper) in {above} of {len(keys)} measures"
    return element(
        "div",
        paragraph(
            "Compensation reduces the tracking error of the simulated drive, as its encoder shows "
            f"it, {text}."
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


REAL = "real stage (paper)"
SIMULATED = "simulated drive"
CALIBRATED = f"{SIMULATED}, calibrated to this row"
EXTRAS = f"{SIMULATED}, all extras on"


def _headline(reproduction: Reproduction) -> Html:
    """Return the errors on the measured velocity, without and with compensation, as rows."""
    own = _measured(reproduction.validation.table())
    extras = reproduction.extras
    validation = extras.validation if extras else None
    rows: list[tuple[str, ...]] = []
    for quantity, label, show in (
        ("without", "Without compensation", _error),
        ("with", "With compensation", _error),
        ("reduction", "Reduction", percent),
    ):
        rows.append((label, REAL, *_cells(own, f"paper_{quantity}", _paper(quantity))))
        # Changed, the drive is no longer the one that was calibrated.
        calibrated = quantity == "without" and not reproduction.options.truth
        drive = CALIBRATED if calibrated else SIMULATED
        rows.append(("", drive, *_cells(own, quantity, show)))
        if validation:
            errors = _measured(validation.table())
            rows.append(("", EXTRAS, *_cells(errors, quantity, show)))
    head = [join([f"{region.capitalize()}, ", METRICS[metric]]) for region, metric in own.index]
    return join(
        [
            table(
                ("", "", *head),
                rows,
                "Velocity errors [mm/s] at motion start and reversal, as the encoder shows them",
                (0, 1),
            ),
            _extras_remark(reproduction),
        ]
    )


def _extras_remark(reproduction: Reproduction) -> Html:
    extras = reproduction.extras
    if extras is None:
        return Html("")
    if extras.validation is None:
        return paragraph(f"With all extras on the drive could not be learned: {extras.reason}.")
    return element(
        "p",
        "“All extras on” is the same drive with every effect of its model: identified, learned and "
        "validated from the beginning, with the same settings.",
        class_="quiet",
    )


def _measured(errors: pd.DataFrame) -> pd.DataFrame:
    return errors[errors["velocity"] == "measured"].set_index(["region", "metric"])


def _cells(errors: pd.DataFrame, column: str, show: Callable[[float], str]) -> list[str]:
    return [show(value) for value in errors[column]]


def _error(value: float) -> str:
    return f"{value:.2f}"


def _paper(quantity: str) -> Callable[[float], str]:
    return (lambda share: percent(share, 0)) if quantity == "reduction" else _error
