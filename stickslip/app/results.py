"""The part of the page that shows results, several of them side by side."""

from pathlib import Path
from typing import Any

from nicegui import ui

import stickslip as ss
from stickslip.app.shown import QUIET, attempt, refreshed, report, show_results
from stickslip.app.workbench import Workbench, titled


def results_part(work: Workbench) -> None:
    """Choose results: one is shown, several are compared."""
    chosen = ui.select(work.results(), label="Results", multiple=True)
    chosen.classes("w-full").props("use-chips")
    refreshed(chosen, work.results)
    place = ui.column().classes("w-full")

    async def show() -> None:
        several = list(chosen.value)
        folders = [work.runs / name for name in several]
        found = await attempt(ss.compare, folders) if several[1:] else None
        if several != chosen.value:  # others were chosen meanwhile
            return
        place.clear()
        with place:
            if not several:
                ui.label(f"Choose results of {work.runs}; several are compared.").classes(QUIET)
            elif len(several) > 1:
                beside(found, folders)
            else:
                show_results(work, several[0], work.jobs.get(several[0]))

    chosen.on_value_change(show)
    ui.timer(0.0, show, once=True)


def beside(found: Any, folders: list[Path]) -> None:
    """Show parameters and errors, if they could be compared, and pages beside each other."""
    if found is not None:
        parameters = found.side_by_side().reset_index()
        for title, frame in {
            "Parameters, with 95 % intervals": parameters,
            "Error left, relative to no compensation": found.errors.frame().round(4),
        }.items():
            ui.label(title).classes(QUIET)
            shown = ui.table.from_pandas(frame, column_defaults={"align": "left"})
            shown.classes("w-full").props("dense flat bordered")
    with ui.row().classes("w-full flex-nowrap max-md:flex-wrap gap-4"):
        for folder in folders:
            with ui.column().classes("min-w-0 grow basis-0 max-md:basis-full"):
                ui.label(titled(folder)).classes("font-bold")
                report(folder)
