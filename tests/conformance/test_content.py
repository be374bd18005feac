"""What lies in an FMU beside binary and description: sources, documents, pictures, results."""

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import matplotlib.image
import numpy as np
import pytest
from fmpy.util import read_csv, read_ref_opt_file
from lxml import etree, html

from stickslip import models
from stickslip.fmi import toolchain
from stickslip.models.export.presentation import reference_file
from stickslip.models.export.sources import fmi_headers, grouped

SCHEMAS = Path(fmpy.__file__).parent / "schema" / "fmi3"
ROOT = Path(models.__file__).parent.parent
LS_REF = "extra/org.fmi-standard.fmi-ls-ref"


def members(fmu):
    with zipfile.ZipFile(fmu.path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_the_sources_are_those_of_the_binary(some_fmu):
    """Compiled again from what is inside, as is stated there, they give the same bytes."""
    content = members(some_fmu)
    [listed] = etree.fromstring(content["sources/buildDescription.xml"]).iter("SourceFileSet")
    flags = ["-Wno-unused-parameter", *listed.attrib["compilerOptions"].split()]
    files = {
        path.removeprefix("sources/"): text.decode()
        for path, text in content.items()
        if path.startswith("sources/") and path.endswith((".c", ".h"))
    }
    headers = fmi_headers(some_fmu.version)
    assert set(headers) & set(files) == (set(headers) if some_fmu.version == 2 else set())
    own = {path: text for path, text in files.items() if path not in headers}
    system = {f"system/{path}": text for path, text in headers.items()}
    library = toolchain.shared_library(
        some_fmu.model.name, grouped(own) | system, flags=flags, standalone=True
    )
    [binary] = [path for path in content if path.startswith("binaries/")]
    assert library.read_bytes() == content[binary]


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("cmake") is None, reason="cmake, which FMPy calls, is missing")
@pytest.mark.parametrize(
    ("name", "version"), [pytest.param("stage", 2, marks=pytest.mark.thorough), ("drive", 3)]
)
def test_another_tool_compiles_the_sources_to_the_same_results(build, name, version, tmp_path):
    fmu = build(name, version)
    path = tmp_path / fmu.path.name
    with zipfile.ZipFile(path, "w") as archive:
        for member, content in members(fmu).items():
            if not member.startswith("binaries/"):
                archive.writestr(member, content)
    subprocess.run(
        [sys.executable, "-m", "fmpy", "compile", str(path)], check=True, capture_output=True
    )
    time = np.arange(300) * 5e-4
    [fed] = fmu.names("input")
    wave = fmu.sizes()[fed] * np.sin(40.0 * time)
    options = {"input": {"time": time, fed: wave}, "output": fmu.names("output", "state")}
    ours, theirs = (fmu.simulate(time[-1], 5e-4, file, **options) for file in (fmu.path, path))
    assert ours.tobytes() == theirs.tobytes()


def test_the_plugs_of_the_loop_fit():
    """Each connection of the paper's loop joins an output to an input of the same name."""
    terminals = {name: models.load_model(name).terminals for name in models.model_names()}
    for name, one, other in (
        ("drive", "velocity_controller", "drive"),
        ("drive", "velocity_controller", "stage"),
        ("friction", "compensator", "velocity_controller"),
        ("motion", "nominal_loop", "compensator"),
        ("measured", "drive", "velocity_filter"),
        ("friction", "compensator", "velocity_filter"),
        ("velocity", "velocity_filter", "velocity_controller"),
    ):
        ends = [terminals[model][name].members for model in (one, other)]
        assert set(ends[0]) == set(ends[1])
        for member in ends[0]:
            fed = [
                variable.role == "input"
                for model, end in zip((one, other), ends, strict=True)
                for variable in models.load_model(model).variables
                if variable.name == end[member]
            ]
            assert sorted(fed) == [False, True]


def test_the_icon_is_a_picture(some_fmu, tmp_path):
    content = members(some_fmu)
    (tmp_path / "icon.png").write_bytes(content["terminalsAndIcons/icon.png"])
    pixels = matplotlib.image.imread(tmp_path / "icon.png")
    assert pixels.shape == (128, 128, 4)
    assert pixels[0, 0, 3] == 0.0  # outside the round corner
    dark = pixels[..., :3].mean(axis=-1) < 0.4
    assert 0.05 < dark.mean() < 0.4
    drawing = etree.fromstring(content["terminalsAndIcons/icon.svg"])
    lines = [e.get("points").split() for e in drawing.iter() if e.tag.endswith("polyline")]
    assert [len(line) for line in lines] == [len(line) // 2 for line in some_fmu.model.icon]
    for line in lines:
        for x, y in (map(float, point.split(",")) for point in line):
            assert dark[int(y * 1.28), int(x * 1.28)]
    assert ("model.png" in content) == (some_fmu.version == 2)


def test_the_documentation_is_the_readme(some_fmu):
    content = members(some_fmu)
    page = html.document_fromstring(content["documentation/index.html"]).text_content()
    rooms = [some_fmu.model.folder, *([some_fmu.model.law.folder] if some_fmu.model.law else [])]
    for room in rooms:
        assert (room / "README.md").read_text(encoding="utf-8") in page
    assert "MIT" in page
    assert content["documentation/licenses/license.txt"].decode() == (ROOT / "LICENSE").read_text()


# Largest distance to reference.csv, in the column's unit. The stage's step is accurate to a part
# in 1e6 of the motion. The drive's puts two constant forces in place of the lagging one, and
# its encoder may show the neighbouring step. What is calculated in closed form or by
# difference equations differs in the last bits only.
TOLERANCE = {
    "stage": {"x": 1e-9, "v": 5e-8, "F_f": 2e-4},
    "drive": {"x_enc": 4.1e-7, "F_m": 1e-12, "F_f": 2e-3, "x": 1e-9, "v": 3e-7},
    "compensator": {"F_f": 1e-12, "F_mean": 1e-12},
    "velocity_controller": {"u": 1e-11, "v_est": 1e-14},
    "velocity_filter": {"v_hat": 1e-13, "d_hat": 1e-8},
    "nominal_loop": {"v_r": 1e-15},
    "static_feedforward": {"F": 1e-12},
    **{f"{name}_observer": {"F": 1e-8, "a_hat": 1e-8} for name in ("coulomb", "momentum")},
    "dob": {"F": 1e-8, "d_hat": 1e-8},
    "lugre_observer": {"F": 1e-8, "z_hat": 1e-14},
    **{f"command_{name}": {"F_ff": 1e-12, "v_r": 1e-15} for name in ("feedforward", "static")},
    **{name: {"F": 1e-9} for name in ("adaptive_scale", "lffc", "lugre_network", "rbf", "mlp")},
}


def test_the_reference_inside_is_met(fmu, tmp_path):
    if reference_file(fmu.model) is None:
        pytest.skip("the reference of a plant is for its default law")
    content = members(fmu)
    manifest = etree.fromstring(content[f"{LS_REF}/fmi-ls-manifest.xml"])
    sources = [related.get("source") for related in manifest.iter("Related")]
    assert {f"{LS_REF}/{source}" for source in sources} | {f"{LS_REF}/fmi-ls-manifest.xml"} == {
        path for path in content if path.startswith("extra/")
    }
    [run] = etree.fromstring(content[f"{LS_REF}/experiments.xml"])
    tables = []
    for tag in ("Stimuli", "References"):
        path = tmp_path / f"{tag}.csv"
        path.write_bytes(content[f"{LS_REF}/{run.find(tag).get('source')}"])
        tables.append(read_csv(path))
    stimuli, expected = tables
    stop, step = (float(run.get(name)) for name in ("stopTime", "stepSize"))
    found = fmu.simulate(stop, step, input=stimuli, output=fmu.names("output"))
    assert set(expected.dtype.names) == {"time", *fmu.names("output")}
    for name in fmu.names("output"):
        tolerance = TOLERANCE[fmu.model.name][name]
        assert np.ptp(expected[name]) > 100 * tolerance
        np.testing.assert_allclose(
            found[name], expected[name], rtol=0.0, atol=tolerance, err_msg=name
        )


def test_other_start_values_have_no_reference_inside(tmp_path):
    with zipfile.ZipFile(models.build_fmu("stage", tmp_path, start={"m": 2.0})) as archive:
        assert not [name for name in archive.namelist() if name.startswith("extra/")]


@pytest.mark.parametrize("name", models.model_names())
def test_cross_check_files_are_as_the_rules_have_them(name, tmp_path):
    written = models.write_cross_check(name, tmp_path)
    assert {path.name.removeprefix(name) for path in written} == {
        *("_in.csv", "_ref.csv", "_ref.opt", "_README.md")
    }
    model = models.load_model(name)
    expected, stimuli = (read_csv(tmp_path / f"{name}_{kind}.csv") for kind in ("ref", "in"))
    assert len(expected.dtype.names) <= 11
    assert (np.diff(expected["time"]) > 0).all()
    assert {*stimuli.dtype.names} == {
        "time",
        *(v.name for v in model.variables if v.role == "input"),
    }
    options = read_ref_opt_file(tmp_path / f"{name}_ref.opt")
    assert options["StopTime"] == expected["time"][-1]
    assert options["StepSize"] == pytest.approx(expected["time"][1])
    head = (tmp_path / f"{name}_ref.csv").read_text().splitlines()[0]
    assert head.startswith('"time","')


def test_units_can_be_shown_as_people_read_them(fmu):
    """1 mm/s is 1e-3 m/s: the factor is how many display units one unit is."""
    if "m/s" not in {v.unit for v in fmu.model.variables}:
        pytest.skip("no velocity")
    [unit] = [u for u in fmu.description.unitDefinitions if u.name == "m/s"]
    assert {d.name: float(d.factor) for d in unit.displayUnits} == {"mm/s": 1000.0}
    shown = {v.name: v.displayUnit for v in fmu.variables.values() if v.unit == "m/s"}
    assert "mm/s" in shown.values()
