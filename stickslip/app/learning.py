"""The part of the page that learns from a log."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from nicegui import events, run, ui

import stickslip as ss
from stickslip.app import charts, jobs
from stickslip.app.jobs import FAULTS, message_of
from stickslip.app.shown import QUIET, attempt, chart, follow, lines_of, told
from stickslip.app.workbench import LOGS, Workbench


def number(text: Any) -> Any:
    """Return a number where a field holds one, else its text, or None where it is empty."""
    try:
        return float(text)
    except (TypeError, ValueError):
        return str(text).strip() or None if text is not None else None


class LogForm:
    """The description of a log, to be corrected: columns, units, controller."""

    SINGLE = (
        "encoder_step",
        "force_limit",
        "rated_force",
        "rated_torque",
        "sample_period",
        "tau_i",
    )

    def __init__(self) -> None:
        self.base = ss.Description()
        self.columns: dict[str, dict[str, Any]] = {}
        self.single: dict[str, Any] = {}
        self.controller: Any = None
        self.gains: Any = None

    def build(self, base: ss.Description, names: Mapping[str, str]) -> None:
        """Build the fields with what a description holds and the columns that a file has."""
        self.base, self.columns, self.single = base, {}, {}
        options: dict[str | None, str] = {
            None: "automatic",
            "none": "none",
            **{name: name for name in names},
        }
        with ui.grid().classes("w-full gap-x-4 gap-y-0 grid-cols-1 md:grid-cols-2"):
            for role in ss.Description.ROLES:
                given = base.column(role)
                with ui.row().classes("flex-nowrap items-start gap-2"):
                    chosen = given.name if given.name in options else None
                    name = ui.select(options, label=role.replace("_", " "), value=chosen)
                    unit = ui.input("unit", value=given.unit)
                    scale = ui.input(
                        "scale", value=None if given.scale is None else str(given.scale)
                    )
                    name.classes("grow min-w-0").props("dense").mark(f"column {role}")
                    unit.classes("w-16").props("dense stack-label").mark(f"unit {role}")
                    scale.classes("w-16").props("dense stack-label")
                self.columns[role] = {"name": name, "unit": unit, "scale": scale}
        with ui.row().classes("w-full gap-4"):
            kinds = list(ss.Description.CONTROLLERS)
            self.controller = ui.select(kinds, label="controller", value=base.controller).classes(
                "w-32"
            )
            gains = " ".join(f"{name}={value}" for name, value in base.gains.items())
            self.gains = ui.input("gains", value=gains, placeholder="K_p=4700 K_i=68000").classes(
                "grow"
            )
            self.gains.props("stack-label hint='" + ", ".join(ss.Description.GAINS) + "; SI units'")
        with ui.expansion("More").classes("w-full"), ui.row().classes("gap-4"):
            motions = {None: "from the units", "linear": "linear", "rotary": "rotary"}
            self.single["motion"] = ui.select(motions, label="motion", value=base.motion).classes(
                "w-40"
            )
            for key in self.SINGLE:
                value = getattr(base, key)
                field = ui.input(key.replace("_", " "), value=value and str(value))
                self.single[key] = field.classes("w-32")

    def detected(self, reading: ss.Reading) -> None:
        """Show beside each field what was detected."""
        for channel in reading.channels:
            field = self.columns[channel.role]
            field["name"].props(
                f'hint="{channel.source}"' if field["name"].value is None else 'hint=""'
            )
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
            **{name: number(field.value) for name, field in self.single.items()},
        )


def learn_part(work: Workbench) -> None:
    """Choose a log, correct what its columns mean, and learn from it."""
    form = LogForm()
    with ui.row().classes("w-full items-end gap-4"):
        log = (
            ui.select(work.files(LOGS), label="Log", with_input=True)
            .classes("grow min-w-60")
            .mark("log")
        )
        config = ui.select({}, label="Description (TOML)", clearable=True).classes("w-56")

        async def uploaded(event: events.UploadEventArguments) -> None:
            path = work.folder / event.file.name
            for k in range(1, 1000):
                if not path.exists():
                    break
                path = work.folder / f"{Path(event.file.name).stem}-{k}{path.suffix}"
            await event.file.save(path)
            upload.reset()
            log.set_options(work.files(LOGS), value=str(path))

        upload = ui.upload(on_upload=uploaded, auto_upload=True, label="Drop a log here")
        upload.props("flat bordered").classes("w-56")
    body = ui.column().classes("w-full")
    outcome = ui.column().classes("w-full")
    with body:
        ui.label(f"Choose a log of {work.folder}, or drop one: it is saved there.").classes(QUIET)

    async def chosen() -> None:
        if not log.value:
            return
        path = Path(log.value)
        own = path.with_suffix(".toml")
        configs, before = work.files({".toml"}), config.value
        config.set_options(configs, value=str(own) if str(own) in configs else None)
        if config.value == before:  # else its change does
            await described()

    async def described() -> None:
        if not log.value:
            return
        base = ss.Description()
        if config.value:
            base = await attempt(ss.load_description, Path(config.value)) or base
        body.clear()
        with body:
            ui.spinner()
        names = await attempt(ss.log_columns, log.value, base) or {}
        body.clear()
        with body:
            form.build(base, names)
            ui.button("Check", icon="rule", on_click=check).props("outline")
            found = ui.column().classes("w-full gap-1").mark("findings")
            with ui.row().classes("w-full items-end gap-4"):
                laws = ["auto", *ss.law_names()]
                law = ui.select(laws, label="Friction law", value="auto").classes("w-40")
                compensator = ui.input("Compensator", value="auto").classes("w-32")
                fixed = ui.checkbox("gains stay as they are")
                force = ui.checkbox("write what is not recommended")
                ui.button("Learn", icon="play_arrow", on_click=lambda: begin())
        form.found = found  # type: ignore[attr-defined]

        async def begin() -> None:
            try:
                description = form.description()
            except FAULTS as fault:
                told(message_of(fault))
                return
            given = {
                "law": law.value,
                "compensator": compensator.value or "auto",
                "fixed_gains": fixed.value,
            }
            job = work.begin(
                "learn",
                log.value,
                jobs.learn,
                log=Path(log.value),
                description=description,
                force=force.value,
                **given,
            )
            follow(work, job, outcome)

        await check()

    async def check() -> None:
        found = form.found  # type: ignore[attr-defined]
        found.clear()
        with found:
            ui.spinner()
        try:
            reading, findings = await run.io_bound(
                lambda: ss.check_log(log.value, form.description())
            )
        except FAULTS as fault:
            found.clear()
            with found:
                lines_of([f"error: {message_of(fault)}"])
            return
        found.clear()
        form.detected(reading)
        with found:
            recording = reading.recording
            shown = {n: getattr(recording, n) for n in ("position", "velocity", "force")}
            for name, values in shown.items():
                if values is not None:
                    chart(f"{name} (SI)", charts.signals(recording.t, {name: values}), "h-40")
            lines_of(map(str, findings))

    log.on_value_change(chosen)
    config.on_value_change(described)
