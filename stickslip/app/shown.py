"""What parts of the page have in common: messages, jobs and folders of results."""

import json
import re
import shutil
import tempfile
from collections.abc import Callable, Iterable, MutableMapping
from functools import partial
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

import pandas as pd
from nicegui import Client, run, ui

import stickslip as ss
from stickslip.app import charts, jobs
from stickslip.app.jobs import FAULTS, Job, message_of
from stickslip.app.workbench import LEARNED, PAGES, Workbench, titled

EVERY = 0.4  # time between two looks at a job [s]
EMPTY = 2.0  # time between two looks for what an empty field could have [s]
_TOLD: MutableMapping[Client, ui.notification] = WeakKeyDictionary()
_FOLLOWED: MutableMapping[ui.element, Job] = WeakKeyDictionary()
QUIET = "text-sm opacity-70"
DEPLOY = "deploy"  # the folder of what goes to the controller
_KEYS = "|".join((*ss.Description.ROLES, *ss.Description.__dataclass_fields__))
_KEY = re.compile(rf"(?<![\w'])(?<!= )({_KEYS})(?![\w'])")
_SEARCH = re.compile(r"'stickslip tune learned.json --set-range (\S+)'")


def worded(text: str) -> str:
    """Return a text that names what is on this page by its labels."""
    text = text.replace("the field 'ROLE'", "its field").replace("of 'ROLE'", "beside it")
    text = _SEARCH.sub(r"Tune with the Ranges '\1'", text)
    return _KEY.sub(lambda found: found[0].replace("_", " "), text)


def told(text: str) -> None:
    """Show the line of an error in place of the one before."""
    quiet()
    _TOLD[ui.context.client] = ui.notification(
        worded(text), type="negative", multi_line=True, timeout=None, close_button="Close"
    )


def quiet() -> None:
    """Take the line of an error away, as something else is done."""
    if line := _TOLD.pop(ui.context.client, None):
        line.dismiss()


def refreshed(field: ui.select, options: Callable[[], Any]) -> ui.select:
    """Return a field that has what there is when it is opened; an empty one cannot be."""

    def look() -> None:
        field.set_options(options(), value=field.value)

    field.on("popup-show", look)
    ui.timer(EMPTY, lambda: None if field.options else look())
    return field


def seen(place: ui.element) -> None:
    """Scroll to what has changed where it is out of sight."""
    ui.run_javascript(f"getHtmlElement({place.id}).scrollIntoView({{block: 'nearest'}})")


def busy(place: ui.element) -> bool:
    """Tell whether what was begun here still runs, and say so."""
    job = _FOLLOWED.get(place)
    if job is None or job.ended:
        return False
    told(f"{job.name} still runs; stop it first, or begin in another tab of the browser")
    return True


async def attempt(work: Callable[..., Any], *args: Any, **given: Any) -> Any:
    """Return what work beside the server returns; show the line of an error, and return None."""
    quiet()
    try:
        return await run.io_bound(work, *args, **given)
    except (*FAULTS, RuntimeError) as fault:
        told(message_of(fault))
        return None


def lines_of(lines: Iterable[str]) -> None:
    """Show findings and warnings, a line each."""
    for line in map(worded, lines):
        kind = line.partition(":")[0]
        icons = {"error": ("error", "negative"), "warning": ("warning", "warning")}
        icon, colour = icons.get(kind, ("info", "grey"))
        with ui.row().classes("items-start flex-nowrap gap-2"):
            ui.icon(icon, color=colour).classes("mt-0.5")
            ui.label(line.removeprefix(f"{kind}: ") if kind in {*icons, "note"} else line)


def show_job(job: Job, then: Callable[[], object]) -> None:
    """Show how far a job is, and what follows when it has ended."""
    with ui.card().classes("w-full"):
        with ui.row().classes("items-center w-full flex-nowrap"):
            ui.spinner(size="sm").bind_visibility_from(job, "ended", backward=lambda one: not one)
            ui.label(job.name).classes("font-bold grow min-w-0 break-words")
            stop = ui.button("Stop", on_click=job.stop).props("flat dense")
        stage = ui.label().classes(QUIET)
        bar = ui.linear_progress(0.0, show_value=False).props("instant-feedback")
        course = ui.column().classes("w-full gap-1")
        with ui.expansion("Messages").classes("w-full") as messages:
            texts = ui.column().classes("w-full gap-1")
    drawn: dict[str, Any] = {"version": -1, "count": 0, "charts": {}, "names": None}

    def draw_search() -> None:
        table = pd.concat(job.candidates, ignore_index=True)
        options = {
            "Cost": charts.history(table),
            "Parallel coordinates": charts.parallel(table, job.names),
            "Importances": charts.importances(table, job.names),
        }
        if drawn["names"] != job.names:
            course.clear()
            with course:
                drawn["charts"] = {title: chart(title, one) for title, one in options.items()}
            drawn["names"] = list(job.names)
        for title, one in options.items():
            drawn["charts"][title].options.update(one)
            drawn["charts"][title].update()

    def look() -> None:
        if drawn["version"] == job.version:
            return
        drawn["version"] = job.version
        bar.value, *counts = job.done
        bar.visible = bar.value is not None and not job.ended
        now = () if job.ended else (job.stages[-1], *counts)
        stage.text = " · ".join(filter(None, (f"{job.of}, since {job.since}", *now)))
        with texts:
            lines_of(job.lines[drawn["count"] :])
        drawn["count"] = len(job.lines)
        messages.text = f"Messages ({len(job.lines)})"
        if job.candidates:
            draw_search()
        if job.ended:
            timer.cancel()
            stop.visible = False
            then()

    timer = ui.timer(EVERY, look)


def chart(title: str, options: charts.Options, height: str = "h-64") -> ui.echart:
    """Show a chart below its title."""
    ui.label(title).classes(QUIET)
    return ui.echart(options).classes(f"w-full {height}")


def show_results(work: Workbench, name: str, job: Job | None = None) -> None:
    """Show a folder of results: what was found, files to download, and the page."""
    folder = work.runs / name
    with ui.card().classes("w-full"):
        ui.label(titled(folder)).classes("font-bold")
        if job is not None and job.error:
            lines_of([f"error: {job.error}"])
        learned = next((folder / one for one in LEARNED if (folder / one).exists()), None)
        if learned:
            verdict(learned)
        if not folder.is_dir():
            return
        with ui.row().classes("gap-2 items-center"):
            if (folder / DEPLOY).is_dir():
                packs = partial(packed, folder / DEPLOY, name)
                _download(f"{DEPLOY}: all code and the steps (zip)", packs)
                ui.link("the steps", f"/files/{name}/{DEPLOY}/steps.html", new_tab=True)
            for file in sorted(folder.glob("*.fmu")):
                _download(file.name, partial(ui.download.file, file))
                if learned:
                    for form in ("c", "st"):
                        export = partial(exported, learned, file.stem, form)
                        _download(f"{file.stem}: {form.upper()}", export)
        if job is not None and job.result:
            with ui.expansion("Details").classes("w-full"):
                lines_of(job.result)
        with ui.expansion("All files").classes("w-full"):
            for path in sorted(folder.rglob("*")):
                if path.is_file():
                    shown = str(path.relative_to(folder))
                    ui.link(shown, f"/files/{name}/{shown}", new_tab=True)
        report(folder)


def verdict(learned: Path) -> None:
    """Show what is to be known first of what was learned."""
    found = json.loads(learned.read_text(encoding="utf-8")).get("verdict")
    if not found:
        return
    ui.label(found["headline"]).classes("font-medium")
    with ui.grid().classes("w-full gap-x-4 gap-y-1 grid-cols-[auto_1fr]"):
        for label, text in found.get("lines", ()):
            ui.label(label.capitalize()).classes(QUIET)
            ui.label(worded(text)).classes("min-w-0 break-words")


def packed(folder: Path, name: str) -> None:
    """Download a folder as one file."""
    with tempfile.TemporaryDirectory() as place:
        file = shutil.make_archive(str(Path(place) / "packed"), "zip", folder)
        ui.download.content(Path(file).read_bytes(), f"{name}-{folder.name}.zip")


def report(folder: Path) -> None:
    """Show the page of a folder of results, which cannot reach this one."""
    for page in PAGES:
        if (folder / page).exists():
            rights = "allow-scripts allow-downloads allow-popups"
            rights += " allow-popups-to-escape-sandbox"  # the steps, in a tab of their own
            frame = ui.element("iframe").classes("report")
            frame.props(f'src="/files/{folder.name}/{page}" sandbox="{rights}" title="Report"')


def _download(label: str, on_click: Callable[[], object]) -> None:
    ui.button(label, icon="download", on_click=on_click).props("outline dense no-caps")


async def exported(learned: Path, part: str, form: str) -> None:
    """Download a part as the command exports it."""
    with tempfile.TemporaryDirectory() as folder:
        for file in await attempt(jobs.export, learned, part, form, Path(folder)) or ():
            ui.download.content(file.read_bytes(), file.name)


def resume(work: Workbench, kind: str, place: ui.element) -> None:
    """Show what was begun in another tab of the browser, or in this one before it was reloaded."""
    with place:
        for job in work.begun(kind):
            follow(work, job, ui.column().classes("w-full"))


def follow(work: Workbench, job: Job, place: ui.element) -> None:
    """Show a job, and its results when it has ended."""

    def ended() -> None:
        with results:
            show_results(work, job.name, job)

    place.clear()
    _FOLLOWED[place] = job
    with place:
        results = ui.column().classes("w-full")  # what is to be known first, above its course
        show_job(job, ended)
