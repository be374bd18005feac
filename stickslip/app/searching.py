"""The parts of the page that start searches: of one loop, and of all compensators in an arena."""

import os
from pathlib import Path
from typing import Any

from nicegui import ui

import stickslip as ss
from stickslip.app import jobs
from stickslip.app.shown import QUIET, attempt, busy, follow, refreshed, resume, told
from stickslip.app.simulating import REAL, spread
from stickslip.app.workbench import LEARNED, MODELS, Workbench

WORKERS = os.cpu_count() or 1


def tune_part(work: Workbench) -> None:
    """Search the loop of a learned drive, or parameters of a system."""
    ui.label("Of a learned drive its loop, of an FMU or SSP what has ranges.").classes(QUIET)
    with ui.row().classes("w-full items-end gap-4"):
        file = ui.select(tunable(work), label="Learned drive, FMU or SSP", with_input=True)
        refreshed(file.classes("grow min-w-60 max-sm:w-full"), lambda: tunable(work))
        cost = ui.select(work.files({".toml"}), label="Cost (TOML)", clearable=True).classes("w-48")
        evaluations = ui.number("Candidates", value=300, min=1, format="%d").classes("w-24")
        seed = ui.number("Seed", value=0, min=0, format="%d").classes("w-16")
        stop = ui.number("Stop time [s]", min=0.0).props("stack-label placeholder='of the file'")
    refreshed(cost, lambda: work.files({".toml"}))
    ranges = ui.input("Ranges", placeholder="").classes("w-full").props("stack-label")
    note = ui.label().classes(QUIET)

    async def chosen() -> None:
        cost.visible = stop.visible = not str(file.value).endswith(".json")
        example, note.text = (file.value and await attempt(advised, file.value)) or ("", "")
        ranges.props["placeholder"] = example
        ranges.update()

    file.on_value_change(chosen)

    def begin() -> None:
        if not file.value:
            told("choose a learned drive, an FMU or an SSP first")
            return
        pairs = (word.partition("=") for word in (ranges.value or "").split())
        spans = {name: span.split(":") for name, _, span in pairs}
        path, learned = Path(file.value), file.value.endswith(".json")
        if not learned and not (spans and cost.value):
            told(f"{path.name}: enter ranges as in '{ranges.props['placeholder']}', choose a cost")
            return
        if busy(place):
            return
        job = work.begin(
            *("tune", [path.parent.name if learned else path.name], jobs.tune),
            source=path,
            cost=None if learned else cost.value,
            ranges=spans,
            evaluations=int(evaluations.value or 300),
            seed=int(seed.value or 0),
            workers=WORKERS,
            **({"stop": stop.value} if stop.value and not learned else {}),
        )
        follow(work, job, place)

    ui.button("Tune", icon="play_arrow", on_click=begin)
    place = ui.column().classes("w-full")
    resume(work, "tune", place)


def tunable(work: Workbench) -> dict[str, str]:
    """Return learned drives as shown by path, then the FMUs and systems that are not of them."""
    files, kind = work.files({".json", *MODELS}), " (learned drive)"
    drives = {path: shown + kind for path, shown in files.items() if Path(path).name in LEARNED}
    own = {Path(path).parent for path in drives}
    models = {path: shown for path, shown in files.items() if not path.endswith(".json")}
    return drives | {path: models[path] for path in models if Path(path).parent not in own}


def advised(path: str) -> tuple[str, str]:
    """Return ranges as an example, and what may be searched in a file."""
    if path.endswith(".json"):
        return "controller.m_ff=0:10", "May be empty; what is given is searched beside the default."
    rows = {row["name"]: row for row in ss.info(path).tables["variables"] if row["type"] in REAL}
    free = {n: row["start"] for n, row in rows.items() if row["causality"] == "parameter"}
    names = spread(free, ())
    spans = [f"{n}={free[n] / 2:.4g}:{2 * free[n]:.4g}" for n in names if (free[n] or 0.0) > 0.0]
    return " ".join(spans[:2]), f"In SI units, of {', '.join(names)}."


def arena_part(work: Workbench) -> None:
    """Compare compensators on drives."""
    ui.label("Each compensator is tuned on each drive, then tried on other motions.").classes(QUIET)
    with ui.row().classes("w-full items-end gap-4"):
        laws = ui.select(ss.law_names(), label="Friction laws", value=["lugre"], multiple=True)
        names = ui.input("Compensators", value="pi static lugre", placeholder="all")
        for one in (laws.props("use-chips"), names):
            one.classes("grow min-w-60")
        evaluations = ui.number("Candidates", value=60, min=10, format="%d").classes("w-24")
        seeds = ui.number("Runs of each command", value=1, min=1, format="%d").classes("w-40")

    def begin() -> None:
        if busy(place):
            return
        given: dict[str, Any] = {
            "laws": laws.value or None,
            "compensators": names.value.split() or None,
        }
        given |= {"evaluations": int(evaluations.value or 10), "seeds": int(seeds.value or 1)}
        job = work.begin("arena", laws.value or ["drives"], jobs.arena, workers=WORKERS, **given)
        follow(work, job, place)

    ui.button("Compare", icon="play_arrow", on_click=begin)
    place = ui.column().classes("w-full")
    resume(work, "arena", place)
