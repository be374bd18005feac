"""The workbench without a browser: what its pages show."""

import asyncio
import json
import shutil
import time
from functools import partial
from types import SimpleNamespace

import pytest

import stickslip as ss
from stickslip import errors
from stickslip.app.jobs import Job, Told
from stickslip.app.workbench import Workbench
from stickslip.models import build_fmu
from tests.kept import ROOT

testing = pytest.importorskip("nicegui.testing", reason="nicegui is not installed")


def opened(work, look):
    """Open the page of a workbench, and let a coroutine look at it."""
    from stickslip.app.pages import page

    async def see():
        async with testing.user_simulation(partial(page, work)) as user:
            await user.open("/")
            await look(user)

    asyncio.run(see())


def endless(*_, **__):
    time.sleep(60.0)


def test_progress_is_what_a_terminal_shows():
    job = Job("learn-axis-1")
    connection = SimpleNamespace(send=lambda news: job._take(**news))
    search = ss.ga.optimiser(
        "default", ss.ga.Problem([ss.ga.Gene("a", 1.0, 2.0, 1.5)]), ss.ga.Limits(evaluations=20)
    )
    assert job.stages == ["loading"]
    with Told(connection) as told:
        told.stage("comparing friction laws")
        told.move(1, 1)  # a single step says nothing
        assert job.done == (None, "", "")
        told.move(5, 5)
        assert job.done == (1.0, "5 of 5 steps", "")
        told.stage("trying compensators")
        assert job.done == (None, "", "")
        told._last = 0.0
        told.move(25, None)
        assert job.done == (None, "25 steps", "")
        search.tell([0.25] * len(search.ask()))
        told._last = 0.0
        told.generation(search)
        n = search.evaluations
        assert job.done == (n / 20, f"{n} of 20 candidates", "best cost 0.25")


def test_fields_in_messages_are_those_of_the_page():
    pages = "".join(
        path.read_text(encoding="utf-8") for path in (ROOT / "stickslip/app").glob("*.py")
    )
    for label in errors._FIELDS.values():
        assert f'"{label}"' in pages


def test_what_can_be_tuned_says_what_it_takes(tmp_path):
    from nicegui import ui

    work = Workbench(tmp_path)
    results = work.runs / "learn-axis-1"
    results.mkdir(parents=True)
    for name in ("learned.json", "manifest.json", "compensator.fmu"):
        (results / name).touch()
    model, learned = str(build_fmu("stage", tmp_path)), str(results / "learned.json")

    async def look(user):
        user.find("Tune").click()
        await user.should_see("Learned drive, FMU or SSP")
        (file,) = user.find("Learned drive, FMU or SSP").elements
        assert [*file.options] == [learned, model]  # no part of what was learned
        assert file.options[learned].endswith("learned.json (learned drive)")
        file.value = model
        await user.should_see("In SI units, of m, b, F_s, F_c, v_s,", retries=20)
        user.find(kind=ui.button, content="Tune").click()
        await user.should_see("stage.fmu: enter ranges as in 'm=2.779:11.11 b=3.307:13.23'")
        assert not work.jobs
        file.value = learned
        await user.should_see("May be empty;", retries=20)
        await user.should_not_see("Cost (TOML)")

    opened(work, look)


def test_a_run_of_too_many_rows_is_refused(tmp_path):
    from nicegui import ui

    model = str(build_fmu("stage", tmp_path))

    async def look(user):
        user.find("Simulate").click()
        await user.should_see("FMU or SSP")
        every = user.find(kind=ui.select, content="FMU or SSP").elements
        (file,) = (one for one in every if one.props["label"] == "FMU or SSP")
        file.value = model
        await user.should_see("Step [s]", retries=60)
        (stop,) = (one for one in user.find("Stop time [s]").elements if one.value)
        stop.value = 1e5
        await user.should_see("rows; the workbench takes 1e+06; choose a larger step", retries=40)

    opened(Workbench(tmp_path), look)


@pytest.mark.parametrize("kind", ["learn", "tune", "arena"])
def test_a_page_shows_what_was_begun_in_another(tmp_path, kind):
    work = Workbench(tmp_path)
    for k in (1, 2):
        name = f"{kind}-axis-{k}"
        work.jobs[name] = Job(name, of=f"axis-{k}.csv", since="12:34", stages=["searching"])
    first, second = work.jobs.values()
    first.ended = True

    async def look(user):
        await user.should_see(f"{kind}-axis-2")
        await user.should_see("axis-2.csv, since 12:34 · searching", retries=20)
        await user.should_not_see(f"{kind}-axis-1")
        second.error, second.ended, second.version = "no friction is seen", True, 1
        await user.should_see("no friction is seen", retries=20)

    opened(work, look)
    if kind == "learn":  # that tab is open when nothing runs
        opened(work, lambda user: user.should_see("no friction is seen", retries=20))


def test_a_run_that_ended_with_its_server_is_told(tmp_path):
    work, marks = Workbench(tmp_path), partial((tmp_path / "runs").glob, "*.running")
    stopped = work.begin("learn", ["other.csv"], endless)
    stopped.stop()
    while not stopped.ended:
        time.sleep(0.05)
    assert not [*marks()]
    ended = work.begin("learn", ["axis.csv"], endless)
    work.close()
    while not ended.ended:
        time.sleep(0.05)
    later = Workbench(tmp_path)
    assert not [*marks()]

    async def look(user):
        await user.should_see("the run ended with its server", retries=20)
        await user.should_see(f"axis.csv, since {ended.since[:10]}")
        await user.should_not_see("other.csv, since")

    opened(later, look)


@pytest.mark.parametrize("gains", ["K_p = 1666 N.s/m, K_i = 1.3e+05 N/m", "controller not known"])
def test_results_are_told_apart_by_date_log_and_gains(tmp_path, gains):
    work = Workbench(tmp_path)
    (work.runs / "learn-axis-1").mkdir(parents=True)
    values = {"m": (8.0, "kg"), "K_p": (1666.1, "N.s/m"), "K_i": (1.3e5, "N/m"), "m_ff": (0, "kg")}
    loop = {name: {"value": value, "unit": unit} for name, (value, unit) in values.items()}
    learned = {"sha256": {"axis.csv": ""}} | ({"loop": loop} if "=" in gains else {})
    (work.runs / "learn-axis-1/learned.json").write_text(json.dumps(learned))
    name = f"learn-axis-1 · {time.strftime('%Y-%m-%d')} "
    assert work.results()["learn-axis-1"].startswith(name)
    assert work.results()["learn-axis-1"].endswith(f" · axis.csv · {gains}")
    work.jobs["learn-axis-1"] = Job("learn-axis-1", ended=True, version=1)
    opened(work, lambda user: user.should_see(f"axis.csv · {gains}", retries=20))


def test_messages_name_what_the_page_shows():
    from stickslip.app.learning import LogForm
    from stickslip.app.shown import worded

    assert worded("unit 'a' of position_command") == "unit 'a' of position command"
    assert worded("force_command = force_command") == "force command = force_command"
    assert worded("column 'sample_period'") == "column 'sample_period'"
    assert worded("UNIT in the field 'unit' of 'ROLE'") == "UNIT in the field 'unit' beside it"
    searched = worded("'stickslip tune learned.json --set-range controller.m_ff=0:11' searches it")
    assert searched == "Tune with the Ranges 'controller.m_ff=0:11' searches it"
    assert all(f"{name} [" in LogForm.UNITS for name in ss.Description.GAINS)


def test_a_page_that_is_loaded_again_has_what_was_entered(tmp_path, log):
    from nicegui import ui

    shutil.copy(log, tmp_path)
    (tmp_path / "own.toml").write_text('[controller]\nkind = "P"\nK_p = 2.0\n')

    def field(user, label):
        every = user.find(content=label, kind=(ui.select, ui.input)).elements
        return min((one for one in every if one.props["label"] == label), key=lambda one: one.id)

    async def look(user):
        await user.should_see("Logs")
        await asyncio.sleep(0.2)
        field(user, "Logs").value = [str(tmp_path / log.name)]
        await user.should_see("the drive moves", retries=100)
        field(user, "Description (TOML)").value = str(tmp_path / "own.toml")
        await user.should_see("a P controller, but", retries=100)
        entered = {"gains": "K_p=3.0", "unit": "furlong", "Friction law": "dahl", "tau i": "0.1"}
        for label, value in entered.items():
            field(user, label).value = value
        await user.open("/")
        await user.should_see("unit 'furlong' of time", retries=100)
        assert {label: field(user, label).value for label in entered} == entered
        assert field(user, "controller").value == "P"
        assert field(user, "Description (TOML)").value == str(tmp_path / "own.toml")

    opened(Workbench(tmp_path), look)
