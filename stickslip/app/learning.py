"""The part of the page that learns from a log."""

from collections.abc import Mapping
from contextlib import suppress
from copy import copy
from dataclasses import replace
from itertools import chain, count
from pathlib import Path
from typing import Any, ClassVar

from nicegui import app as pages
from nicegui import events, run, ui

import stickslip as ss
from stickslip.app import charts, jobs
from stickslip.app.jobs import FAULTS, message_of
from stickslip.app.shown import (
    QUIET,
    attempt,
    busy,
    chart,
    follow,
    lines_of,
    refreshed,
    resume,
    seen,
    told,
)
from stickslip.app.workbench import LOGS, Workbench

TAKEN = {*LOGS, ".toml", ".fmu", ".ssp"}  # files that may be dropped


def number(text: Any) -> Any:
    """Return a number where a field holds one, else its text, or None where it is empty."""
    with suppress(TypeError, ValueError):
        return float(text)
    return str(text or "").strip() or None


class LogForm:
    """The description of a log, to be corrected: columns, units, controller."""

    SINGLE: ClassVar = {
        "encoder_step": "m or rad", "force_limit": "N or N m", "rated_force": "N",
        "rated_torque": "N m", "sample_period": "s", "tau_i": "s",
    }  # fmt: skip
    UNITS = "K_x [1/s], velocity_feedforward [0 to 1], P_x [N/m], I_x [N/(m s)], K_p [N s/m],"
    UNITS += " K_i [N/m], tau_f [s], T_s [s], u_max [N]; rotary: N m for N, rad for m"

    def __init__(self) -> None:
        self.fields: list[Any] = []  # all of the page below the choice of logs
        self.first = ""  # the log that it describes
        self.base = ss.Description()
        self.names: list[str] = []  # of the columns in the log
        self.columns: dict[str, dict[str, Any]] = {}
        self.single: dict[str, Any] = {}

    def build(self, base: ss.Description, names: Mapping[str, str]) -> None:
        """Build the fields with what a description holds and the columns that a file has."""
        self.base, self.names, self.columns, self.single = base, [*names], {}, {}
        with ui.grid().classes("w-full gap-x-4 gap-y-0 grid-cols-1 md:grid-cols-2"):
            for role in ss.Description.ROLES:
                given = base.column(role)
                options: dict[str | int | None, str] = {None: "automatic", "none": "none"}
                options |= {name: str(name) for name in (*names, given.name) if name is not None}
                scale = None if given.scale is None else str(given.scale)
                with ui.row().classes("flex-nowrap items-start gap-2"):
                    fields = {
                        "name": ui.select(options, label=role.replace("_", " "), value=given.name),
                        "unit": ui.input("unit", value=given.unit).classes("w-16"),
                        "scale": ui.input("scale", value=scale).classes("w-16"),
                    }
                    fields["name"].classes("grow min-w-0")
                for field in fields.values():
                    field.props("dense stack-label bottom-slots")
                self.columns[role] = fields
        with ui.row().classes("w-full gap-4"):
            kinds = list(ss.Description.CONTROLLERS)
            self.controller = ui.select(kinds, label="controller", value=base.controller)
            self.controller.classes("w-32")
            gains = " ".join(f"{name}={value}" for name, value in base.gains.items())
            self.gains = ui.input("gains", value=gains, placeholder="K_p=4700 K_i=68000")
            self.gains.classes("grow min-w-60").props("stack-label")
        ui.label(self.UNITS).classes(QUIET)
        with ui.expansion("More").classes("w-full"), ui.row().classes("gap-4"):
            motions = {None: "from the units", "linear": "linear", "rotary": "rotary"}
            self.single["motion"] = ui.select(motions, label="motion", value=base.motion)
            for key, unit in self.SINGLE.items():
                value = getattr(base, key)
                self.single[key] = ui.input(key.replace("_", " "), value=value and str(value))
                self.single[key].props(f'hint="{unit}"')
            self.confirm = ui.input("confirm", value=" ".join(base.confirm))
            for field in (*self.single.values(), self.confirm):
                field.classes("w-36")

    def detected(self, reading: ss.Reading) -> None:
        """Show beside each field what was detected."""
        for channel in reading.channels:
            field = self.columns[channel.role]
            source = channel.source if field["name"].value is None else ""
            field["name"].props["hint"] = source
            field["name"].update()
            field["unit"].props["placeholder"] = channel.unit.name if channel.unit else "SI"
            field["unit"].update()

    def description(self) -> ss.Description:
        """Return what the fields describe; raise UsageError where that makes no sense."""
        columns = {}
        for role, fields in self.columns.items():
            given: dict[str, Any] = {part: field.value or None for part, field in fields.items()}
            given["scale"] = number(given["scale"])
            if any(value is not None for value in given.values()):
                columns[role] = replace(self.base.column(role), **given)
        pairs = (pair.partition("=") for pair in (self.gains.value or "").replace(",", " ").split())
        return replace(
            self.base,
            columns=columns,
            controller=self.controller.value,
            gains={name: number(value) for name, _, value in pairs},
            confirm=tuple((self.confirm.value or "").split()),
            **{name: number(field.value) for name, field in self.single.items()},
        )


def learn_part(work: Workbench) -> None:
    """Choose logs of a drive, correct what their columns mean, and learn from them together."""
    form = LogForm()
    with ui.row().classes("w-full items-end gap-4"):
        log = ui.select(work.logs(), label="Logs", multiple=True, with_input=True)
        refreshed(log.classes("grow min-w-60").props("use-chips"), work.logs)
        config = ui.select({}, label="Description (TOML)", clearable=True).classes("w-56")

        async def uploaded(event: events.UploadEventArguments) -> None:
            path = work.folder / event.file.name
            if Path(path.name.lower().removesuffix(".gz")).suffix not in TAKEN:
                upload.reset()
                told(f"{path.name}: no log; expected one of {', '.join(sorted(TAKEN))}")
                return
            others = (path.with_stem(f"{path.stem}-{k}") for k in count(1))
            path = next(one for one in chain([path], others) if not one.exists())
            await event.file.save(path)
            upload.reset()
            ui.notify(f"saved as {path}")
            logs = work.logs()
            log.set_options(logs, value=[*log.value, *{str(path)}.intersection(logs)])

        upload = ui.upload(on_upload=uploaded, auto_upload=True, multiple=True)
        upload.props("flat bordered label='Drop logs here'").classes("w-56")
    outcome = ui.column().classes("w-full")
    resume(work, "learn", outcome)
    body = ui.column().classes("w-full")
    with body:
        ui.label(
            f"Choose one or several logs of a drive in {work.folder}, or drop them: they are saved"
            " there. All have the description of the first."
        ).classes(QUIET)

    async def chosen() -> None:
        if not log.value or form.first == log.value[0]:
            return
        form.first = log.value[0]
        own = Path(log.value[0]).with_suffix(".toml")
        configs, before = work.files({".toml"}), config.value
        config.set_options(configs, value=str(own) if str(own) in configs else None)
        if config.value == before:  # else its change does
            await described()

    async def reloaded() -> None:
        nonlocal form
        before, logs, own = pages.storage.tab.get("learn", (form, log, config))
        if logs.value and {*logs.value} <= {*log.options}:
            form, configs = copy(before), work.files({".toml"})  # a duplicated tab has its own
            config.set_options(configs, value=own.value if own.value in configs else None)
            log.value = logs.value
            await described(again=True)
        pages.storage.tab["learn"] = form, log, config
        log.on_value_change(chosen)
        config.on_value_change(described)

    async def described(*, again: bool = False) -> None:
        if not log.value:
            return
        given = config.value and await attempt(ss.load_description, Path(config.value))
        base = given or ss.Description()
        body.clear()
        with body:
            ui.spinner()
        names = await attempt(ss.log_columns, log.value[0], base) or {}
        entered: list[Any] = []
        if names and [*names] == form.names and (again or not config.value):  # it was corrected
            base, entered = form.base, [field.value for field in form.fields]
        body.clear()
        with body:
            found = ui.column().classes("w-full gap-1")
            with ui.expansion("Columns and controller", value=True).classes("w-full"):
                form.build(base, names)
            with ui.row().classes("w-full items-end gap-4"):
                laws = ["auto", *ss.law_names()]
                law = ui.select(laws, label="Friction law", value="auto").classes("w-40")
                compensator = ui.input("Compensator", value="auto").classes("w-32")
                fixed = ui.checkbox("gains stay as they are")
                force = ui.checkbox("write what is not recommended")
            signals = ui.column().classes("w-full")
            with ui.card().props("flat square").classes("w-full flex-row sticky bottom-0 z-10 p-2"):
                ui.button("Check", icon="rule", on_click=lambda: check_again())
                ui.button("Learn", icon="play_arrow", on_click=lambda: begin())
        form.fields = [one for one in body.descendants() if hasattr(one, "value")]
        for field, value in zip(form.fields, entered, strict=False):
            field.value = value

        async def begin() -> None:
            description = await attempt(form.description)
            if description is None or busy(outcome):
                return
            job = work.begin(
                *("learn", log.value, jobs.learn),
                logs=list(log.value),
                description=description,
                law=law.value,
                compensator=compensator.value or "auto",
                fixed_gains=fixed.value,
                force=force.value,
            )
            follow(work, job, outcome)
            seen(outcome)

        async def check() -> None:
            found.clear()
            signals.clear()
            with found:
                ui.spinner()
                try:
                    description = form.description()
                    checked: list[Any] = [
                        await run.io_bound(ss.check_log, one, description) for one in log.value
                    ]
                except FAULTS as fault:
                    found.clear()
                    lines_of([f"error: {message_of(fault)}"])
                    return
                found.clear()
                form.detected(checked[0][0])
                for reading, findings in checked:
                    ui.label(reading.recording.source).classes(QUIET)
                    lines_of(map(str, findings))
            recordings = [reading.recording for reading, _ in checked]
            with signals:
                for name in ("position", "velocity", "force"):
                    shown = [one for one in recordings if getattr(one, name) is not None]
                    if drawn := {one.source: (one.t, getattr(one, name)) for one in shown}:
                        chart(f"{name} (SI)", charts.signals(drawn), "h-40")

        async def check_again() -> None:
            await check()
            seen(found)

        await check()

    ui.timer(0.0, reloaded, once=True)
