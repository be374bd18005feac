"""Figures that a page opens: their data are those of the picture, and a browser draws them."""

import base64
import gzip
import json
import re
import shutil
import subprocess

import numpy as np
import pytest
from matplotlib.figure import Figure

from stickslip.presentation import interactive
from stickslip.presentation.interactive import keep, name_points, panels, plain
from stickslip.presentation.page import Section, write_page

T = np.linspace(0.0, 2.0, 200)


def long() -> Figure:
    """Two panels with a common time axis, and one of points on a logarithmic axis."""
    figure = Figure()
    upper = figure.add_subplot(3, 1, 1)
    lower = figure.add_subplot(3, 1, 2, sharex=upper)
    other = figure.add_subplot(3, 1, 3)
    upper.plot(T, np.sin(T), label="$v_{cmd}$", color="#e07b00")
    upper.plot(T, np.where(T < 1.0, np.nan, T), "--")
    upper.axhline(0.5)
    lower.plot(T, T**2)
    lower.set(xlabel="Time [s]", ylabel=r"Position [$\mu$m]")
    other.loglog(1.0 + T, 1.0 + T, ".")
    return figure


def short() -> Figure:
    figure = Figure()
    figure.subplots().plot([0.0, 1.0], [0.0, 1.0])
    return figure


def figures(*draws) -> Section:
    """Return a section with figures by the names of what draws them."""
    shown = {draw.__name__: draw for draw in draws}
    content = (
        "{% for name in names %}{% call figure(name, 'drawn') %}A figure.{% endcall %}{% endfor %}"
    )
    return Section("Figures", content, shown, names=list(shown))


def decoded(page: str, name: str) -> str:
    (packed,) = re.findall(f'id="{name}">([^<]*)<', page)
    return gzip.decompress(base64.b64decode(packed)).decode()


def test_panels_are_the_lines_of_the_figure():
    upper, lower, other = panels(long())
    assert [panel["link"] for panel in (upper, lower, other)] == [0, 0, 2]
    assert [line["label"] for line in upper["lines"]] == ["v_cmd", ""]  # not the level of 0.5
    assert [line["dashed"] for line in upper["lines"]] == [False, True]
    np.testing.assert_allclose(upper["lines"][0]["y"], np.sin(T), rtol=1e-5)
    gap = np.array(upper["lines"][1]["y"], dtype=float)
    np.testing.assert_array_equal(np.isnan(gap), T < 1.0)
    assert lower["y"]["label"] == "Position [μm]"
    assert (other["x"]["scale"], other["lines"][0]["joined"]) == ("log", False)
    assert panels(short()) == []
    assert plain(r"$\sigma_0$ [m/s$^2$]") == "σ_0 [m/s²]"


def test_named_points_open_with_the_words_of_their_axis():
    figure = Figure()
    axes = figure.subplots()
    (dots,) = axes.plot([3.0, 4.0], [0.0, 1.0], "o")
    assert panels(figure) == []
    axes.set_yticks([0.0, 1.0], ["first", "second"])
    name_points(dots, ["a", "b"])
    (panel,) = panels(figure)
    assert (panel["x"]["words"], panel["y"]["words"]) == ({}, {0.0: "first", 1.0: "second"})
    assert (panel["lines"][0]["names"], panel["lines"][0]["mark"]) == (["a", "b"], "o")
    polar = Figure()
    polar.add_subplot(projection="polar").plot(T, T)
    assert panels(polar) == []


def test_a_thinned_line_opens_with_the_points_that_were_kept():
    figure = Figure()
    (line,) = figure.subplots().plot(T[::4], T[::4])
    keep(line, T, T)
    (panel,) = panels(figure)
    np.testing.assert_allclose(panel["lines"][0]["x"], T, rtol=1e-5)


def test_a_page_carries_data_and_library_of_what_opens(tmp_path):
    write_page(tmp_path, "Both", [figures(long, short)], "both.html")
    page = (tmp_path / "both.html").read_text()
    assert re.findall('data-plot="(.*?)"', page) == ["long"]
    assert json.loads(decoded(page, "plots")) == {"long": json.loads(json.dumps(panels(long())))}
    assert "Bokeh" in decoded(page, "bokeh")
    write_page(tmp_path, "Other", [figures(short)], "other.html")
    assert "<script" not in (tmp_path / "other.html").read_text()


def test_the_library_is_what_the_wheel_carries_or_the_package_else_there_is_none(
    tmp_path, monkeypatch
):
    monkeypatch.setattr(interactive, "find_spec", lambda _: None)
    monkeypatch.setattr(interactive, "CARRIED", tmp_path / "bokeh.js.gz")
    monkeypatch.setattr(interactive, "bokeh", interactive.bokeh.__wrapped__)
    write_page(tmp_path, "One", [figures(long)], "one.html")
    page = (tmp_path / "one.html").read_text()
    assert "<script" not in page
    assert "data:image/svg" in page
    interactive.CARRIED.write_bytes(gzip.compress(b"carried"))
    write_page(tmp_path, "One", [figures(long)], "one.html")
    assert decoded((tmp_path / "one.html").read_text(), "bokeh") == "carried"


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("chromium") is None, reason="Chromium is not installed here")
def test_a_browser_opens_the_figure(tmp_path):
    write_page(tmp_path, "One", [figures(long)])
    page = tmp_path / "report.html"
    click = "<script>setTimeout(() => document.querySelector('button.open').click(), 500)</script>"
    page.write_text(page.read_text().replace("</body>", f"{click}</body>"))
    command = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--dump-dom"]
    done = subprocess.run(
        [*command, "--virtual-time-budget=10000", page.as_uri()],
        capture_output=True, text=True, timeout=60, check=True,
    )  # fmt: skip
    dialog = done.stdout.partition("<dialog")[2]
    assert dialog.split(">")[0].endswith('open=""')
    assert "bk-Column" in dialog  # what is below it is in shadow roots
