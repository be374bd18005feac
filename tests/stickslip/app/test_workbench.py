"""The workbench, as a user sees it in a browser."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import zipfile
from contextlib import contextmanager

import pytest

import stickslip as ss
from stickslip.app.workbench import Workbench
from stickslip.models import build_fmu
from tests.kept import ROOT

sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
pytest.importorskip("nicegui", reason="nicegui is not installed")
httpx = pytest.importorskip("httpx")  # which nicegui requires
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium")]
LONG = 300_000  # a learning, on a busy machine [ms]


BRIEF = """import sys
if any("spawn_main" in word for word in sys.orig_argv):
    from tests.stickslip.brief import briefly
    brief = briefly()
    brief.__enter__()
"""
"""What a process of Python runs when it starts, so that the one that learns is brief."""


@contextmanager
def serving(folder, log, places=()):
    """Start the workbench of a folder; yield the process, its address and the folder."""
    text = log.read_text(encoding="utf-8").replace("time,position,force", "a,b,c", 1)
    (folder / "unnamed.csv").write_text(text, encoding="utf-8")
    build_fmu("stage", folder)
    words = [sys.executable, "-m", "stickslip", "app", str(folder), "--no-browser"]
    given = {"PYTHONPATH": os.pathsep.join(map(str, places))} if places else {}
    with subprocess.Popen(
        words, stdout=subprocess.PIPE, text=True, env=os.environ | given
    ) as process:
        try:
            (address,) = re.findall(r"http\S+", process.stdout.readline())
            yield process, address, folder
        finally:
            process.terminate()


@pytest.fixture(scope="module")
def server(tmp_path_factory, log):
    with serving(tmp_path_factory.mktemp("server"), log) as found:
        yield found


@pytest.fixture
def brief_server(tmp_path_factory, log):
    place = tmp_path_factory.mktemp("place")
    (place / "sitecustomize.py").write_text(BRIEF)
    with serving(tmp_path_factory.mktemp("server"), log, (place, ROOT)) as found:
        yield found


@pytest.fixture(scope="module")
def browser():
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield browser
        browser.close()


def opened(browser, address):
    page = browser.new_context(accept_downloads=True).new_page()
    page.set_default_timeout(30_000)
    page.goto(address)
    return page


def choose(page, field, item):
    page.get_by_label(field, exact=True).locator("visible=true").first.click()
    page.locator(".q-menu .q-item", has_text=item).first.click()
    page.keyboard.press("Escape")  # of several items, the menu stays
    page.locator(".q-menu").wait_for(state="hidden")


@pytest.mark.thorough
def test_from_a_dropped_log_to_the_downloaded_compensator(brief_server, browser, log):
    process, address, folder = brief_server
    page = opened(browser, address)
    second = folder.parent / "second.csv"
    shutil.copy(log, second)
    page.locator("input[type=file]").first.set_input_files(log)
    findings = page.get_by_text("the drive moves")
    findings.wait_for()
    page.locator("input[type=file]").first.set_input_files(second)
    page.locator(".q-chip", has_text="second.csv").wait_for()
    assert (folder / log.name).read_bytes() == log.read_bytes()
    photo = {"name": "photo.png", "mimeType": "image/png", "buffer": b"PNG"}
    page.locator("input[type=file]").first.set_input_files(photo)
    page.get_by_text("photo.png: no log; expected one of").wait_for()
    assert not (folder / "photo.png").exists()

    # What the command line would print, for a unit that is wrong and one that contradicts.
    unit = page.get_by_label("unit", exact=True).nth(2)
    unit.fill("furlong")
    page.get_by_role("button", name="Check").click()
    page.get_by_text("unit 'furlong' of force is unknown; expected").wait_for()
    unit.fill("")
    page.get_by_role("button", name="Check").click()
    findings.nth(1).wait_for()  # of each log

    # Another tab has a state of its own, and lets columns be named that nothing detects.
    other = opened(browser, address)
    choose(other, "Logs", "unnamed.csv")
    other.get_by_text("no column of time; give NAME in the field 'time'").wait_for()
    for role, column in {"time": "a", "position": "b", "force": "c"}.items():
        choose(other, role, re.compile(f"^{column}$"))
    other.get_by_role("button", name="Check").click()
    other.get_by_text("the drive moves").wait_for()
    assert page.locator(".q-chip").all_inner_texts()[0].startswith(log.name)

    # A log with the same columns keeps what was entered.
    shutil.copy(folder / "unnamed.csv", folder / "corrected.csv")
    choose(other, "Logs", "corrected.csv")
    chip = other.locator(".q-chip", has_text="unnamed.csv")
    chip.locator(".q-chip__icon--remove").click()
    other.get_by_text("corrected.csv").nth(1).wait_for()  # beside the chip, over the findings
    other.get_by_text("the drive moves").wait_for()

    choose(page, "Friction law", "dahl")
    page.get_by_label("Compensator").first.fill("static")
    page.get_by_role("button", name="Learn").click()
    page.get_by_role("button", name="Learn").click()
    page.get_by_text("learn-log-1 still runs; stop it first").wait_for()
    page.get_by_text("Importances").wait_for(timeout=LONG)
    third = opened(browser, address)
    third.get_by_text(re.compile(r"^log.csv, second.csv, since .*\d\d:\d\d")).wait_for()
    page.get_by_text("Coulomb feedforward (static)").first.wait_for(timeout=LONG)
    check = page.get_by_text("drive disabled: a slow positive")
    assert check.bounding_box()["y"] < 720.0  # without scrolling
    report = page.frame_locator("iframe.report")
    report.get_by_text("log.csv").first.wait_for()
    with page.expect_download() as download:
        page.get_by_role("button", name="compensator.fmu").click()
    with zipfile.ZipFile(download.value.path()) as fmu:
        assert "modelDescription.xml" in fmu.namelist()
    with page.expect_download() as download:
        page.get_by_role("button", name="deploy: all code and the steps (zip)").click()
    with zipfile.ZipFile(download.value.path()) as deployed:
        assert {"added_force.c", "steps.html"} <= {*deployed.namelist()}
    with page.expect_popup() as steps:
        page.get_by_role("link", name="the steps", exact=True).click()
    steps.value.get_by_text("Commission").first.wait_for()
    offered = {*Workbench(folder).logs().values()}
    assert offered == {"unnamed.csv", "corrected.csv", log.name, second.name}  # no table of results
    learned = json.loads((folder / "runs/learn-log-1/learned.json").read_text(encoding="utf-8"))
    assert {*learned["sha256"]} == {log.name, second.name}

    # The field of results was empty when the other tab was opened.
    other.get_by_role("tab", name="Results").click()
    choose(other, "Results", "learn-log-1")
    other.get_by_text("drive disabled: a slow positive").wait_for()

    # On a telephone tables go on to the right, where they fade, and the page does not.
    shutil.copytree(folder / "runs/learn-log-1", folder / "runs/learn-log-2")
    other.set_viewport_size({"width": 390, "height": 800})
    choose(other, "Results", "learn-log-2")
    table = other.locator(".q-table__middle").first
    table.wait_for(timeout=LONG)
    assert table.evaluate("one => one.scrollWidth > one.clientWidth")
    fade = "one => getComputedStyle(one).getPropertyValue('--fade')"
    assert table.evaluate(fade) == "48px"
    table.evaluate("one => one.scrollTo(one.scrollWidth, 0)")
    other.wait_for_timeout(500)
    assert table.evaluate(fade) == "0px"
    assert other.evaluate("document.scrollingElement.scrollWidth") == 390

    process.send_signal(signal.SIGINT)
    page.get_by_text("The server has gone.").wait_for()
    assert process.wait(20) == 0


def test_learn_stands_below_what_it_uses_and_stays_in_sight(server, browser):
    page = opened(browser, server[1])
    page.set_viewport_size({"width": 390, "height": 600})
    choose(page, "Logs", "unnamed.csv")
    page.get_by_text("no column of time").wait_for()
    learn, gains = page.get_by_role("button", name="Learn"), page.get_by_label("gains", exact=True)
    assert learn.bounding_box()["y"] < 600.0 < gains.bounding_box()["y"]
    page.get_by_role("button", name="Check").scroll_into_view_if_needed()
    page.mouse.wheel(0, 5000)
    page.wait_for_timeout(500)
    assert gains.bounding_box()["y"] < learn.bounding_box()["y"] < 600.0
    page.get_by_role("button", name="Check").click()  # shows what it finds
    page.wait_for_timeout(1000)
    assert page.get_by_text("no column of time").bounding_box()["y"] > 35.0
    assert page.evaluate("document.scrollingElement.scrollWidth") == 390


def test_a_slider_moves_the_result(server, browser):
    page = opened(browser, server[1])
    page.get_by_role("tab", name="Simulate").click()
    choose(page, "FMU or SSP", "stage.fmu")
    page.locator("canvas").first.wait_for()
    before = page.locator("canvas").first.screenshot()
    page.locator(".q-slider").first.click(position={"x": 200, "y": 8})
    page.wait_for_timeout(1500)
    assert page.locator("canvas").first.screenshot() != before


def test_an_exposed_input_gets_a_constant_or_a_signal(server, browser):
    _, address, folder = server
    system = ss.System("loop")
    system.add("c", build_fmu("velocity_controller", folder))
    system.add("stage", folder / "stage.fmu")
    system.expose("v_cmd", "c.v_cmd", "c.v_hat")
    system.connect("c.u", "stage.u")
    times = ss.cosim.DefaultExperiment(stop=0.1, step=5e-4)
    ss.cosim.write_ssp(system, folder / "loop.ssp", times)
    (folder / "command.csv").write_text("time,v_cmd\n0,0\n0.1,0.25\n", encoding="utf-8")

    page = opened(browser, address)
    page.get_by_role("tab", name="Simulate").click()
    choose(page, "FMU or SSP", "loop.ssp")
    page.get_by_text("v_cmd [m/s]").nth(1).wait_for()  # of the slider, and of the first chart
    for title in ("c.u [N]", "stage.x [m]"):
        page.get_by_text(title, exact=True).wait_for()
    idle = page.get_by_text(re.compile("v_cmd = 0.0 m/s.* signals by the field 'Input signals'"))
    idle.wait_for()
    at_rest = page.locator("canvas").nth(1).screenshot()
    page.locator("input[type=number]").nth(2).fill("0.05")
    idle.wait_for(state="detached")
    page.wait_for_timeout(1000)
    constant = page.locator("canvas").nth(1).screenshot()
    assert constant != at_rest
    choose(page, "Input signals", "command.csv")
    page.get_by_text("v_cmd: by the input signals").wait_for()
    page.wait_for_timeout(1000)
    assert page.locator("canvas").nth(1).screenshot() != constant
    page.get_by_label("Step [s]").fill("0.0004")
    page.get_by_text("samples late or not at all; choose 0.00025 s").wait_for()


def test_requests_without_the_token_or_from_another_page_are_refused(server):
    plain, token = server[1].split("?token=")
    foreign = {"Origin": "http://localhost:3000"}
    for address, headers in (
        (plain, {}),
        (f"{plain}?token={token[:-1]}", {}),
        (f"{plain}files/learn/learned.json", {"Cookie": f"stickslip={token}"}),
        (server[1], foreign),
    ):
        assert httpx.get(address, headers=headers).status_code == 403
    assert httpx.get(f"{plain}files/..%2Fstage.fmu?token={token}").status_code == 404
    assert "HttpOnly" in httpx.get(server[1]).headers["set-cookie"]
