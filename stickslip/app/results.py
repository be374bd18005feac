"""The part of the page that shows results, several of them side by side."""

from __future__ import annotations

from typing import Any

from nicegui import ui

import stickslip as ss
from stickslip.app.shown import PAGES, QUIET, attempt, follow, report, show_results
from stickslip.app.workbench import LEARNED, Workbench


def results_part(work: Workbench) -> None:
    """Choose results: one is shown, several are compared; jobs are followed."""

    def names() -> list[str]:
        running = [job.name for job in work.jobs.values() if not job.ended]
        return [*running, *work.results(*LEARNED, *PAGES)]

    with ui.row().classes("w-full items-center"):
        chosen = (
            ui.select(names(), label="Results", multiple=True).classes("grow").props("use-chips")
        )
        ui.button(icon="refresh", on_click=lambda: chosen.set_options(names())).props("flat round")
    chosen.on("popup-show", lambda: chosen.set_options(names()))
    place = ui.column().classes("w-full")

    async def show() -> None:
        place.clear()
        several = list(chosen.value)
        with place:
            if not several:
                ui.label(f"Choose results of {work.runs}; several are compared.").classes(QUIET)
            elif len(several) > 1:
                await compare(work, several)
            elif (job := work.jobs.get(several[0])) and not job.ended:
                follow(work, job, place)
            else:
                show_results(work, several[0], job)

    chosen.on_value_change(show)
    ui.timer(0.0, show, once=True)


async def compare(work: Workbench, names: list[str]) -> None:
    """Show parameters, errors and pages of results beside each other."""
    paths = [
        next((f for f in (work.runs / n / one for one in LEARNED) if f.exists()), work.runs / n)
        for n in names
    ]
    found = await attempt(ss.compare, paths)
    if found is not None:
        table(
            "Parameters, with 95 % intervals", found.side_by_side().reset_index().to_dict("records")
        )
        table("Error left, relative to no compensation", found.errors.frame().to_dict("records"))
    with ui.row().classes("w-full flex-nowrap max-md:flex-wrap gap-4"):
        for name in names:
            with ui.column().classes("min-w-0 grow basis-0 max-md:basis-full"):
                ui.label(name).classes("font-bold")
                report(work.runs / name)


def table(title: str, rows: list[dict[Any, Any]]) -> None:
    """Show rows as a table; numbers have four digits."""
    ui.label(title).classes(QUIET)
    shown = [
        {
            str(k): f"{v:.4g}".replace("nan", "–") if isinstance(v, float) else v
            for k, v in row.items()
        }
        for row in rows
    ]
    columns = [
        {"name": key, "label": key, "field": key, "align": "left"}
        for key in (shown[0] if shown else ())
    ]
    ui.table(rows=shown, columns=columns).classes("w-full").props("dense flat bordered wrap-cells")
