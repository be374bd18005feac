"""The part of the page that runs an FMU or a system while its parameters are moved."""

from typing import Any

from nicegui import ui

import stickslip as ss
from stickslip.app import charts
from stickslip.app.shown import QUIET, attempt, chart
from stickslip.app.workbench import MODELS, Workbench

SLIDERS, SIGNALS = 6, 3  # that are shown at first
REAL = ("Real", "Float64", "Float32")
STEPS = 200  # of a slider
WIDEST = 100.0  # range of a slider over the start value


def simulate_part(work: Workbench) -> None:
    """Choose a file, move its parameters and see what it does."""
    with ui.row().classes("w-full items-end gap-4"):
        file = ui.select(work.files(MODELS), label="FMU or SSP", with_input=True).classes("grow")
        stop = ui.number("stop time [s]", min=0.0).classes("w-32")
    file.on("popup-show", lambda: file.set_options(work.files(MODELS), value=file.value))
    place = ui.column().classes("w-full")

    async def opened() -> None:
        place.clear()
        if file.value and (info := await attempt(ss.info, file.value)):
            stop.value = info.facts["experiment"].get("stop") or 1.0
            with place:
                await Bench(file.value, info, stop).run()

    file.on_value_change(opened)


class Bench:
    """A file, the sliders of its parameters, and the result of its last run."""

    def __init__(self, path: str, info: Any, stop: ui.number) -> None:
        self.path, self.stop = path, stop
        rows = [row for row in info.tables["variables"] if row["type"] in REAL]
        lone = "components" not in info.tables
        kinds = {"parameter": False, "input": True} if lone else {"parameter": False}
        self.rows = {row["name"]: row for row in rows if row["causality"] in kinds}
        self.outputs = {row["name"] for row in rows if row["causality"] == "output"}
        self.moved: dict[str, float] = {}
        self.first: ss.Result | None = None
        self.last: ss.Result | None = None
        self.busy = self.again = False
        first = sorted(self.rows, key=lambda name: "[" in name)[:SLIDERS]
        with ui.row().classes("w-full items-start flex-nowrap max-md:flex-wrap gap-6"):
            with ui.column().classes("w-80 max-md:w-full gap-1 shrink-0"):
                names = ui.select(
                    [*self.rows], label="Parameters", value=first, multiple=True, with_input=True
                )
                names.classes("w-full").props("use-chips")
                self.sliders = ui.column().classes("w-full gap-0")
            with ui.column().classes("grow min-w-0 w-full"):
                self.signals = ui.select([], label="Signals", multiple=True, with_input=True)
                self.signals.classes("w-full").props("use-chips")
                ui.label("Dashed: before a parameter was moved.").classes(QUIET)
                self.plots = ui.column().classes("w-full gap-1")
        names.on_value_change(lambda event: self.show_sliders(event.value))
        self.signals.on_value_change(self.draw)
        stop.on_value_change(self.run)
        self.show_sliders(first)

    def show_sliders(self, names: list[str]) -> None:
        """Show a slider for each of some parameters."""
        self.sliders.clear()
        with self.sliders:
            for name in names:
                self.slider(name, self.rows[name])

    def slider(self, name: str, row: dict[str, Any]) -> None:
        """Show a slider from the lowest to the highest value, or from a fifth to five times it."""
        start = row["start"] if isinstance(row["start"], int | float) else 0.0
        low, high = row["minimum"], row["maximum"]
        if low is None or high is None or not high - low < WIDEST * abs(start):
            low, high = sorted((start / 5.0, 5.0 * start)) if start else (-1.0, 1.0)
        value = self.moved.get(name, start)
        with ui.row().classes("w-full items-center justify-between flex-nowrap"):
            ui.label(f"{name} [{row['unit']}]" if row["unit"] else name).classes("text-sm truncate")
            field = ui.number(value=value, format="%.6g").props("dense borderless").classes("w-24")
        bar = ui.slider(min=low, max=high, step=(high - low) / STEPS, value=value)
        bar.bind_value(field)
        if row["description"]:
            bar.tooltip(row["description"])

        async def moved() -> None:
            if field.value is not None and field.value != self.moved.get(name, start):
                self.moved[name] = field.value
                await self.run()

        field.on_value_change(moved)

    async def run(self) -> None:
        """Run with the present values; of several changes meanwhile, with the last."""
        self.again = True
        if self.busy:
            return
        self.busy = True
        while self.again:
            self.again = False
            inputs = {n: v for n, v in self.moved.items() if self.rows[n]["causality"] == "input"}
            parameters = {n: v for n, v in self.moved.items() if n not in inputs}
            given = {"parameters": parameters, "stop": self.stop.value, "inputs": inputs or None}
            result = await attempt(ss.simulate, self.path, **given)
            if result is None:
                break
            self.first, self.last = self.first or result, result
            if not self.signals.options:
                outputs = [name for name in result.names if name in self.outputs]
                shown = (outputs or [*result.names])[-SIGNALS:]
                self.signals.set_options([*result.names], value=shown)
            self.draw()
        self.busy = False

    def draw(self) -> None:
        """Draw the chosen signals, each in a chart."""
        first, last = self.first, self.last
        if first is None or last is None:
            return
        options = {}
        for name in self.signals.value:
            before = (first.time, first[name]) if self.moved else None
            options[name] = charts.signals({name: (last.time, last[name])}, before)
        shown = [child for child in self.plots.descendants() if isinstance(child, ui.echart)]
        if len(shown) == len(options):
            for old, new in zip(shown, options.values(), strict=True):
                old.options.update(new)
                old.update()
            return
        self.plots.clear()
        with self.plots:
            for name, new in options.items():
                chart(name, new, "h-52")
