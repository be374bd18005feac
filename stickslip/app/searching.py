"""The parts of the page that start searches: of one loop, and of all compensators in an arena."""

import os
from pathlib import Path

from nicegui import ui

import stickslip as ss
from stickslip.app import jobs
from stickslip.app.shown import QUIET, busy, follow, refreshed, resume, told
from stickslip.app.workbench import LEARNED, MODELS, Workbench

WORKERS = os.cpu_count() or 1


def tune_part(work: Workbench) -> None:
    """Search the loop of a learned drive, or parameters of a system."""
    ui.label("The loop of a learned drive, or parameters of an FMU or SSP with a cost.").classes(
        QUIET
    )
    with ui.row().classes("w-full items-end gap-4"):
        file = ui.select(
            _learned(work), label="Learned drive, FMU or SSP", with_input=True
        ).classes("grow min-w-60")
        cost = ui.select(work.files({".toml"}), label="Cost (TOML)", clearable=True).classes("w-48")
        evaluations = ui.number("Candidates", value=300, min=1, format="%d").classes("w-24")
        seed = ui.number("Seed", value=0, min=0, format="%d").classes("w-16")
        stop = ui.number("Stop time [s]", min=0.0).props("stack-label placeholder='of the file'")
    refreshed(file, lambda: _learned(work))
    refreshed(cost, lambda: work.files({".toml"}))
    ranges = ui.input(
        "Ranges", placeholder="controller.K_p=1000:5000 controller.K_i=10000:200000"
    ).classes("w-full")
    ranges.props(
        "stack-label hint='in SI units; of a learned drive beside what is searched by default'"
    )

    def begin() -> None:
        if not file.value:
            told("choose a learned drive, an FMU or an SSP first")
            return
        if busy(place):
            return
        pairs = (word.partition("=") for word in (ranges.value or "").split())
        spans = {name: span.split(":") for name, _, span in pairs}
        path = Path(file.value)
        learned = path.suffix == ".json"
        job = work.begin(
            *("tune", [path.parent.name if learned else path.name], jobs.tune),
            source=path,
            cost=None if learned else cost.value,
            ranges=spans,
            evaluations=int(evaluations.value or 10),
            seed=int(seed.value or 0),
            workers=WORKERS,
            **({"stop": stop.value} if stop.value and not learned else {}),
        )
        follow(work, job, place)

    ui.button("Tune", icon="play_arrow", on_click=begin)
    place = ui.column().classes("w-full")
    resume(work, "tune", place)


def _learned(work: Workbench) -> dict[str, str]:
    files = work.files({".json", *MODELS})
    return {
        path: shown
        for path, shown in files.items()
        if not path.endswith(".json") or Path(path).name in LEARNED
    }


def arena_part(work: Workbench) -> None:
    """Compare compensators on drives."""
    ui.label("Each compensator is tuned on each drive, then tried on other motions.").classes(QUIET)
    with ui.row().classes("w-full items-end gap-4"):
        laws = ui.select(
            ss.law_names(), label="Drives of friction laws", value=["lugre"], multiple=True
        )
        laws.classes("grow min-w-60").props("use-chips")
        names = ui.input("Compensators", value="pi static lugre", placeholder="all").classes(
            "grow min-w-60"
        )
        evaluations = ui.number("Candidates", value=60, min=10, format="%d").classes("w-24")
        seeds = ui.number("Runs of each command", value=1, min=1, format="%d").classes("w-40")

    def begin() -> None:
        if busy(place):
            return
        given = {"laws": laws.value or None, "compensators": names.value.split() or None}
        budget = {
            "evaluations": int(evaluations.value or 10),
            "seeds": int(seeds.value or 1),
            "workers": WORKERS,
        }
        follow(work, work.begin("arena", ["drives"], jobs.arena, **given, **budget), place)

    ui.button("Compare", icon="play_arrow", on_click=begin)
    place = ui.column().classes("w-full")
    resume(work, "arena", place)
