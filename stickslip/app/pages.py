"""The page of the workbench: each tab of the browser has one, with a state of its own."""

from collections.abc import Callable

from nicegui import ui

from stickslip.app.learning import learn_part
from stickslip.app.results import results_part
from stickslip.app.searching import arena_part, tune_part
from stickslip.app.shown import quiet
from stickslip.app.simulating import simulate_part
from stickslip.app.workbench import Workbench

PARTS: dict[str, Callable[[Workbench], None]] = {
    "Learn": learn_part,
    "Results": results_part,
    "Simulate": simulate_part,
    "Tune": tune_part,
    "Arena": arena_part,
}
STYLE = """
.q-notifications__list--bottom { margin-bottom: 64px }
.nicegui-content { padding: 0 } .q-tab-panel { padding: 16px } body { overflow-x: hidden }
.q-panel-parent, .q-panel, .q-tab-panel { overflow: visible }
.wide { width: 100%; max-width: 72rem; margin: auto } .q-notification { --q-primary: currentColor }
.q-uploader__list { min-height: 20px; padding: 0 8px }
@media (max-width: 480px) { .q-header { padding: 0 } .q-tab { padding: 0 9px; min-width: 0 } }
@property --fade { syntax: "<length>"; inherits: false; initial-value: 0px; }
@keyframes ends { from { --fade: 3rem } }
.q-table__middle { animation: ends linear; animation-timeline: scroll(self inline);
  mask: linear-gradient(to right, #000 calc(100% - var(--fade)), transparent) }
iframe.report { width: 100%; height: 85vh; border: 1px solid #8884; border-radius: 6px }
"""


def page(work: Workbench) -> None:
    """Build the page of a tab of the browser."""
    ui.colors(primary="#2f7fb8")
    ui.add_css(STYLE)
    with ui.header().classes("items-center px-4 py-0 gap-4 flex-nowrap"):
        ui.label("stickslip").classes("text-lg font-bold max-sm:hidden")
        tabs = ui.tabs(on_change=quiet).props("dense mobile-arrows no-caps")
        with tabs.classes("grow min-w-0"):
            for name in PARTS:
                ui.tab(name)
    running = (name.split("-")[0].title() for name, job in work.jobs.items() if not job.ended)
    *_, shown = "Learn", *running
    with ui.tab_panels(tabs, value=shown).classes("wide bg-transparent"):
        for name, part in PARTS.items():
            with ui.tab_panel(name):
                part(work)
