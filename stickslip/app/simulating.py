"""The part of the page that runs an FMU or a system while its parameters are moved."""

import warnings
from collections import Counter
from collections.abc import Iterable
from threading import Lock
from typing import Any

from nicegui import ui

import stickslip as ss
from stickslip.app import charts
from stickslip.app.shown import QUIET, attempt, chart, lines_of, refreshed, told
from stickslip.app.workbench import MODELS, Workbench

SLIDERS, SIGNALS = 6, 4  # that are shown at first
TABLES = {".csv", ".parquet"}
REAL = ("Real", "Float64", "Float32")
STEPS = 200  # of a slider
ROWS = 1e6  # of a run, most; 100 times as many took 10 GB
WIDEST = 100.0  # range of a slider over the start value
ONE_RUN = Lock()  # at a time: Python collects the warnings of a process, not of a thread


def simulate_part(work: Workbench) -> None:
    """Choose a file, move its parameters and see what it does."""
    file = ui.select(work.files(MODELS), label="FMU or SSP", with_input=True).classes("w-full")
    refreshed(file, lambda: work.files(MODELS))
    place = ui.column().classes("w-full")

    async def opened() -> None:
        place.clear()
        if file.value and (info := await attempt(ss.info, file.value)):
            with place:
                await Bench(work, file.value, info).run()

    file.on_value_change(opened)


def titled(name: str, unit: str | None) -> str:
    """Return a name with its unit."""
    return f"{name} [{unit}]" if unit else name


def spread(names: Iterable[str], first: Iterable[str]) -> list[str]:
    """Return names in another order: some first, then one of each component before a second.

    Elements of arrays and sample periods are the last.
    """
    counts, ranks = Counter[str](), dict[str, tuple[bool, bool, int]]()
    for name in names:
        component, last = name.partition(".")[0], "[" in name or name.split(".")[-1] == "T_s"
        ranks[name] = (name not in first, last, counts[component])
        counts[component] += not last
    return sorted(ranks, key=lambda name: ranks[name])


class Bench:
    """A file, the sliders of its inputs and parameters, and the result of its last run."""

    def __init__(self, work: Workbench, path: str, info: Any) -> None:
        self.path = path
        rows = {row["name"]: row for row in info.tables["variables"] if row["type"] in REAL}
        free = {name: row for name, row in rows.items() if not row.get("source")}
        parameters = {name: row for name, row in free.items() if row["causality"] == "parameter"}
        idle = {name: row for name, row in free.items() if row["causality"] == "input"}
        self.exposed = idle
        if "inputs" in info.tables:
            targets = {row["name"]: row["to"][0] for row in info.tables["inputs"]}
            self.exposed = {name: rows[one] for name, one in targets.items() if one in rows}
        self.rows = self.exposed | parameters | idle
        self.packed = self.driven = {*info.facts.get("signals", ())}  # inputs that have signals
        self.moved: dict[str, float] = {}
        self.first: ss.Result | None = None
        self.last: ss.Result | None = None
        self.held: Any = None  # what the first run had beside its parameters
        self.busy = self.again = False
        times = info.facts["experiment"]
        self.usual = times.get("step") or 1e-3
        with ui.row().classes("w-full items-start flex-nowrap max-md:flex-wrap gap-6"):
            with ui.column().classes("w-80 max-md:w-full gap-1 shrink-0"):
                with ui.grid(columns=2).classes("w-full"):
                    self.stop = ui.number("Stop time [s]", value=times.get("stop") or 1.0, min=0.0)
                    self.step = ui.number("Step [s]", value=times.get("step"), min=0.0)
                    self.step.props("placeholder=automatic stack-label")
                table = ui.select(work.files(TABLES), label="Input signals", clearable=True)
                table.classes("w-full").props("hint='a table with columns time and one per input'")
                self.table = refreshed(table, lambda: work.files(TABLES))
                moving = sorted(self.rows, key=lambda name: not self.rows[name]["start"])
                label, chosen = "Inputs and parameters", spread(moving, self.exposed)[:SLIDERS]
                self.names = ui.select(
                    [*self.rows], label=label, value=chosen, multiple=True, with_input=True
                )
                self.names.classes("w-full mt-2").props("use-chips")
                self.sliders = ui.column().classes("w-full gap-0")
            with ui.column().classes("grow min-w-0 w-full"):
                self.signals = ui.select([], label="Signals", multiple=True, with_input=True)
                self.signals.classes("w-full").props("use-chips")
                self.notes = ui.column().classes("w-full gap-1")
                ui.label("Dashed: the first run with these inputs.").classes(QUIET)
                self.plots = ui.column().classes("w-full gap-1")
        self.names.on_value_change(self.show_sliders)
        self.signals.on_value_change(self.draw)
        for field in (self.stop, self.step, self.table):
            field.props("debounce=400").on_value_change(self.run)
        self.show_sliders()

    def show_sliders(self) -> None:
        """Show a slider for each input and parameter that was chosen."""
        self.sliders.clear()
        with self.sliders:
            for name in self.names.value:
                if name in self.driven:
                    ui.label(f"{name}: by the input signals").classes("text-sm py-2")
                else:
                    self.slider(name, self.rows[name])

    def slider(self, name: str, row: dict[str, Any]) -> None:
        """Show a slider from the lowest to the highest value, or from a fifth to five times it."""
        start = row["start"] if isinstance(row["start"], int | float) else 0.0
        low, high = row["minimum"], row["maximum"]
        if low is None or high is None or not high - low < WIDEST * abs(start):
            low, high = sorted((start / 5.0, 5.0 * start)) if start else (-1.0, 1.0)
        value = self.moved.get(name, start)
        with ui.row().classes("w-full items-center justify-between flex-nowrap"):
            ui.label(titled(name, row["unit"])).classes("text-sm truncate")
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
            table, stop, step = self.table.value, self.stop.value, self.step.value or None
            inputs = {n: v for n, v in self.moved.items() if self.rows[n]["causality"] == "input"}
            rows, done = (stop or 0.0) / (step or self.usual), None
            if rows > ROWS:
                what = f"a run of {rows:.2g} rows; the workbench takes {ROWS:.0e}"
                told(f"{what}; choose a larger step or an earlier stop time")
            else:
                done = await attempt(self.simulated, table, {**self.moved}, stop=stop, step=step)
            if done is None:
                self.plots.clear()  # of other inputs
                break
            self.last, driven, lines = done
            if self.held != (held := (table, stop, step, inputs)):
                self.first, self.held = self.last, held
            self.notes.clear()
            with self.notes:
                lines_of(lines)
            if driven != self.driven:
                self.driven = driven
                self.show_sliders()
            if not self.signals.options:
                names = self.last.names
                self.signals.set_options([*names], value=spread(names, self.exposed)[:SIGNALS])
            self.draw()
        self.busy = False

    def simulated(
        self, table: str | None, values: dict[str, float], **given: Any
    ) -> tuple[ss.Result, set[str], list[str]]:
        """Run with a table and other values; return result, what is driven, and warnings."""
        inputs = ss.read_tables(table) if table else None
        driven = self.packed if inputs is None else {*inputs}
        given["parameters"] = {name: v for name, v in values.items() if name not in driven}
        with ONE_RUN, warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", UserWarning)
            result = ss.simulate(self.path, inputs=inputs, **given)
        return result, driven, [f"warning: {one.message}" for one in caught]

    def draw(self) -> None:
        """Draw the chosen signals, each in a chart."""
        first, last = self.first, self.last
        if first is None or last is None:
            return
        options = {}
        for name in self.signals.value:
            before = (first.time, first[name]) if first is not last else None
            title = titled(name, last.units[name])
            options[title] = charts.signals({name: (last.time, last[name])}, before)
        shown = [child for child in self.plots.descendants() if isinstance(child, ui.echart)]
        if len(shown) == len(options):
            for old, new in zip(shown, options.values(), strict=True):
                old.options.update(new)
                old.update()
            return
        self.plots.clear()
        with self.plots:
            for title, new in options.items():
                chart(title, new, "h-52")
