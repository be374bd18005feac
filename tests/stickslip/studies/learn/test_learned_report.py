"""The report on one recording: for linear and rotary drives, and where friction was measured."""

import re
from dataclasses import replace
from html import unescape
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest

from stickslip import ga
from stickslip.catalog.parameters import DRIVE, LUGRE, PAPER, ParameterSpace, friction_law
from stickslip.evaluation.tracking import FEEDFORWARD, FRICTIONLESS, NONE, Tracking, TrackingError
from stickslip.identification.criteria.controller_check import ControllerCheck
from stickslip.identification.criteria.goodness_of_fit import GoodnessOfFit
from stickslip.identification.estimation import Estimation, Identifiability
from stickslip.identification.estimation.faults import HeldOut
from stickslip.identification.fitting.fit import Fit
from stickslip.identification.fitting.start import Start
from stickslip.logs import Finding, Recording
from stickslip.logs.recording import Segment
from stickslip.presentation.page import Picture
from stickslip.presentation.quantity import interval, number
from stickslip.presentation.scale import thinned
from stickslip.presentation.style import house_style
from stickslip.studies.learn.page import FIGURES, use, write_estimation_report
from stickslip.studies.learn.page.figures import _resolved, draw_recording, draw_residual
from stickslip.studies.learn.page.tracking import tracking_section, window
from tests.kept import further

pytestmark = pytest.mark.slow

FINDINGS = (
    Finding("note", "it moves", "84 % of the time"),
    Finding("warning", "F_s & v_s hardly show", "3 %", "stickslip plan --show F_s v_s"),
)
KINDS = ("rotary", "friction")
VALUES = {**PAPER, "F_0": 0.3, "delay": 1e-4, "delta": 2.0, "i": 1.0, "v_d": 0.0}


def identifiability(name, level="identifiable"):
    value = VALUES[name]
    error = 0.01 * value
    text = f"{level}, +-2 %, of {name}"
    return Identifiability(value, error, value - 2 * error, value + 2 * error, level, text)


def profile(name, steepness=1.0):
    points = np.arange(-3.0, 4.0)
    values = VALUES[name] * np.exp(0.01 * points)
    return pd.DataFrame({"parameter": name, "value": values, "deviance": steepness * points**2})


def algorithm():
    genes = [ga.Gene(name, 0.1 * PAPER[name], 10 * PAPER[name], PAPER[name]) for name in LUGRE]
    learning = ga.GeneticAlgorithm(genes, ga.Settings(population=4, generations=1), seed=0)
    learning.tell(np.arange(float(len(learning.ask()))))
    return learning


def made(kind="loop", n=30_000):
    """An estimation of a sine; where friction was measured, by Dahl's law.

    The law's first parameter is not identifiable, and the profile of its last one is too steep.
    """
    law = friction_law("dahl" if kind == "friction" else "lugre")
    space = ParameterSpace.of(law)
    hidden, *_, steep = space.friction
    values = {name: VALUES[name] for name in (*law.parameters, *DRIVE)}
    t = np.arange(n) * 5e-4
    x = 0.02 * np.sin(2.0 * t)
    v = 0.04 * np.cos(2.0 * t)
    force = 6.0 * np.sign(v) + 0.3
    noise = np.random.default_rng(1).normal(0.0, 0.1, n)
    measured = {"friction": force + noise} if kind == "friction" else {"force": force + noise}
    recording = Recording(
        t, x, velocity_command=v, encoder_step=4e-7,
        motion="rotary" if kind == "rotary" else "linear", source="a & b.csv", **measured,
    )  # fmt: skip
    k = len(space.names)
    fit = Fit(space, space.encode(values), noise, np.zeros((n, k)), 1e-4 * np.eye(k), 0.01)
    simulated = None if kind == "friction" else x + 3e-7
    nan = float("nan")
    loop = (nan, nan, nan) if simulated is None else (1.5e-4, 0.0171, 0.0426)
    names = space.friction if kind == "friction" else space.reported
    known = {name: identifiability(name) for name in names}
    known[hidden] = identifiability(hidden, "not identifiable")
    return Estimation(
        recording=recording,
        criterion="inverse model" if kind == "friction" else "output error",
        reason="for a reason < others",
        start=Start(values, space),
        fit=fit,
        known=known,
        parameters=values,
        errors={name: 0.01 * value for name, value in values.items()},
        profiles=pd.concat(
            [profile(name, 100.0 if name == steep else 1.0) for name in space.friction]
        ),
        searched=algorithm(),
        held_out=HeldOut((), ()),
        figures=GoodnessOfFit(
            0.1234, 0.2, *loop, t, force + noise, force, simulated, v, 0.0, slice(65, -65)
        ),
        controller=None if simulated is None else ControllerCheck(force, 6e-4, 1, {}),
        model_error=0.6,
        remarks=("the sign was turned",),
    )


@pytest.fixture(scope="module", params=[KINDS[0], *further(KINDS[1])])
def written(request, tmp_path_factory):
    """The kind, its estimation, and a folder with its report."""
    folder = tmp_path_factory.mktemp("report") / request.param
    folder.mkdir()
    (folder / "learned.json").write_text("{}")
    estimation = made(request.param)
    files = write_estimation_report(estimation, FINDINGS, folder)
    assert {path.name for path in folder.iterdir()} == {f.name for f in files} | {"learned.json"}
    return request.param, estimation, folder


def words(folder):
    """The page's text, without style, scripts and markup."""
    page = (folder / "report.html").read_text(encoding="utf-8").split("</style>")[1]
    page = re.sub("(?s)<script.*?</script>", "", page)
    return unescape(re.sub("<[^>]*>", "", page)).replace("\u00a0", " ")


def drawn(folder, name):
    """The words of a picture, which its SVG file keeps as comments beside their outlines."""
    svg = (folder / f"{name}.svg").read_text(encoding="utf-8")
    ElementTree.fromstring(svg)  # noqa: S314 - our own file
    return " ".join(re.findall("<!-- (.*?) -->", svg))


def test_every_parameter_appears_with_interval_unit_and_sentence(written):
    kind, estimation, folder = written
    table, text = pd.read_csv(folder / "parameters.csv").set_index("parameter"), words(folder)
    assert list(table.index) == list(estimation.known)
    for name, known in estimation.known.items():
        row = table.loc[name]
        assert [row.value, row.standard_error] == [known.value, known.standard_error]
        assert (row.low, row.high, row.sentence) == (known.low, known.high, known.sentence)
        assert known.sentence.replace("+-", "±") in text
        scale = 1e3 if name == "v_s" else 1.0
        assert interval(scale * known.low, scale * known.high).replace("\u00a0", " ") in text
    assert table.unit["F_c"] == ("N.m" if kind == "rotary" else "N")
    assert ("kg m²" in text) == (kind == "rotary")
    assert ("mrad/s" if kind == "rotary" else "mm/s") in text or kind == "friction"
    assert ("LuGre" if kind != "friction" else "Dahl") + " model of friction" in text
    assert ("Stiffness of the contact at rest" in text) == (kind == "friction")


def test_the_page_names_criterion_errors_findings_and_files(written):
    kind, estimation, folder = written
    text = words(folder)
    assert f"Criterion: {estimation.criterion}, since {estimation.reason}." in text
    assert "12.3 %" in text
    assert ("0.015 %" in text) == (kind != "friction")
    assert not re.search(r"\bnan\b", text.lower())
    for finding in FINDINGS:
        assert all(part in text for part in (finding.what, finding.figure, finding.advice))
    assert "the sign was turned" in text
    assert text.index(FINDINGS[1].what) < text.index(FINDINGS[0].what)  # warnings first
    assert "learned.json:" in text
    assert "compensator.fmu:" not in text  # which is not there


def test_what_is_not_visible_is_not_praised_and_an_experiment_is_named(written):
    kind, estimation, folder = written
    text, name = words(folder), estimation.fit.space.friction[0]
    letter = {"F_s": "Fs", "sigma_0": "σ0"}[name]
    assert f"Not identifiable: {letter}." in text
    assert re.search(rf"Identifiable: [^.]*{letter}", text) is None
    assert f"≈ {number(estimation.known[name].value, 2)}".replace("\u00a0", " ") in text
    motion = " --motion rotary" if kind == "rotary" else ""
    recorded = estimation.recording.t[-1] - estimation.recording.t[0]
    longer = f"--duration {2 * np.ceil(recorded):.0f}"
    assert f"stickslip plan --show {name} {longer}{motion}" in text


def test_pictures_show_units_of_the_drive(written):
    kind, _, folder = written
    force, length = ("N m", "mrad") if kind == "rotary" else ("N", "mm")
    texts = {name: drawn(folder, name).replace("\u00a0", " ") for name in FIGURES}
    assert f"[{length}]" in texts["recording"]
    assert f"[{force}]" in texts["recording"]
    assert f"[{force}]" in texts["force"]
    assert "relative error 12.3 %" in texts["force"].replace("\u00a0", " ")
    assert ("Hysteresis" in texts["force"]) == (kind == "friction")
    assert ("learned Stribeck curve" in texts["force"]) == (kind != "friction")
    assert ("one step of the encoder" in texts["residual"]) == (kind != "friction")
    assert all((folder / f"{name}.svg").stat().st_size < 1_000_000 for name in FIGURES)
    assert (folder / "report.html").stat().st_size < 2_000_000


def test_a_profile_too_steep_for_its_interval_is_not_drawn(written):
    kind, _, folder = written
    texts, text = drawn(folder, "profiles"), words(folder)
    assert texts.count("profile not resolved") == 1
    assert f"Not drawn for {'Fc' if kind == 'friction' else 'σ1'}" in text
    assert not _resolved(np.zeros(7))  # nor one that nothing raises
    assert _resolved(np.arange(-3.0, 4.0) ** 2)


def test_a_disturbance_of_one_frequency_is_a_peak_of_the_spectrum():
    estimation = made("loop")
    figures, t = estimation.figures, estimation.recording.t
    disturbed = figures.simulated + 1e-6 * np.sin(2 * np.pi * 50.0 * t)
    estimation = replace(estimation, figures=replace(figures, simulated=disturbed))
    with house_style():
        figure = draw_residual(estimation)
    (line,) = figure.axes[-1].get_lines()
    f, density = line.get_data()
    assert f[np.argmax(density)] == pytest.approx(50.0, abs=f[1] - f[0])
    # In its bins the disturbance has its RMS, in micrometres.
    near = abs(f - 50.0) < 5.0
    assert np.sqrt(np.sum(density[near] ** 2) * (f[1] - f[0])) == pytest.approx(0.5**0.5, rel=0.01)


def test_what_joins_two_logs_is_not_drawn():
    estimation = made("loop")
    pieces = Segment(0, 10_000, "one"), Segment(11_000, 30_000, "other")
    recording = replace(estimation.recording, segments=pieces)
    with house_style():
        figure = draw_recording(replace(estimation, recording=recording))
    for axes in figure.axes:
        shown = [t for line in axes.get_lines() if len(t := line.get_xdata()) > 2]
        assert shown
        for t in shown:
            assert not np.any((t >= recording.t[10_000]) & (t < recording.t[11_000]))
            assert np.count_nonzero(np.isnan(t)) == 1


@pytest.mark.parametrize(("error", "beside", "offered"), [
    (6e-4, ("learned.json", "compensator.fmu"), True),
    (0.9, ("learned.json", "compensator.fmu"), False),
    (6e-4, ("learned.json",), False),
])  # fmt: skip
def test_tuning_is_offered_where_the_loop_is_known_and_something_is_written(error, beside, offered):
    estimation = made(n=2000)
    known = replace(estimation, controller=replace(estimation.controller, error=error))
    page = str(use(known, beside).markup({}))
    assert ("stickslip tune learned.json" in page) == offered


def test_a_thinned_signal_keeps_its_extremes_and_its_order():
    t = np.arange(100_000) * 1e-3
    signal = np.random.default_rng(2).normal(size=len(t))
    signal[777], signal[55_555] = 9.0, -9.0
    fewer, shown = thinned(t, signal, columns=50)
    assert len(fewer) <= 100
    assert (shown.min(), shown.max()) == (-9.0, 9.0)
    assert np.all(np.diff(fewer) > 0.0)
    assert np.array_equal(np.interp(fewer, t, signal), shown)


def tracked(measured=None):
    """A sine whose velocity error is 2, 1 and 0.5 mm/s, and ten times as large for a while."""
    t = np.arange(2000) * 1e-3
    v_cmd = 0.02 * np.sin(5.0 * t)
    shape = np.where((t > 1.2) & (t < 1.25), 10.0, 1.0) * 1e-3
    sizes = {NONE: 2.0, FEEDFORWARD: 1.0, FRICTIONLESS: 0.5}
    velocity = {name: v_cmd + size * shape for name, size in sizes.items()}
    position = {name: size * 1e-5 * np.ones_like(t) for name, size in sizes.items()}
    words = ("the log's PI controller", "the log's own command")
    return Tracking(t, v_cmd, velocity, position, slice(0, None), *words, True, measured)


def test_the_section_labels_measured_and_simulated_and_names_loop_and_command():
    measured = TrackingError(2.1e-3, 2.2e-2, 2e-5, 3e-5)
    section = tracking_section(tracked(measured), "linear")
    pictures = {name: Picture.of(draw) for name, draw in section.figures.items()}
    text = re.sub("<[^>]*>", "|", section.markup(pictures)).replace("\u00a0", " ")
    for label in ("Measured, log", "Simulated, without", "Simulated, with", "50 %"):
        assert label in text
    assert "in the loop of the log’s PI controller" in text
    blank = dict.fromkeys(section.figures, Picture(b"", b"", 89.0))
    assert "Measured" not in tracking_section(tracked(), "linear").markup(blank)


def test_the_detail_is_where_compensation_changes_most():
    part = window(tracked())
    assert part.start / 1e3 < 1.25
    assert part.stop / 1e3 > 1.2
