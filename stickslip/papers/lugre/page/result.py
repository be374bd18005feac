"""The head of the page: what was done, the result, and the errors at a glance."""

from __future__ import annotations

from functools import partial

from stickslip import models
from stickslip.papers.lugre.loop_tuning import FRICTION
from stickslip.papers.lugre.page.loop_tuning import draw_stages
from stickslip.papers.lugre.page.section import section
from stickslip.papers.lugre.reproduction import Reproduction
from stickslip.papers.lugre.steps import FILTERED, REDUCTION_WITH_FILTER
from stickslip.presentation.page import Section
from stickslip.presentation.quantity import METRICS, number, percent, unit
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
    """Return what was done, what each step brings, and the verdict."""
    table = reproduction.table4()
    own = table[table["velocity"] == "measured"]
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
    switches = [name for name, v in variables.items() if v.type == "boolean"]
    effects = {
        state: [EFFECTS.get(n, n) for n in switches if bool(reproduction.truth[n]) == state]
        for state in (True, False)
    }
    loops = reproduction.loops
    return section(
        "",
        "result",
        reproduction,
        {"loop_tuning": partial(draw_stages, loops)},
        feed=FEEDS[reproduction.options.feed],
        FRICTION=[f"{level:g}" for level in FRICTION],
        changes=changes,
        effects=effects,
        better=int((own["reduction"] > own["paper_reduction"]).sum()),
        found=_tiles(reproduction),
    )


def _tiles(reproduction: Reproduction) -> list[tuple[str, ...]]:
    """Return the reductions of the measured errors, each with those beside it."""
    table = reproduction.table4()
    own, true = (table[table["velocity"] == shown] for shown in ("measured", "true"))
    extras = reproduction.extras.table4 if reproduction.extras else None
    found = []
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
        found.append((name, percent(row["reduction"]), *beside))
    return found
