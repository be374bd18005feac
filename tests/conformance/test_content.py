"""What lies in an FMU: sources, documents, pictures, results, and libraries for all platforms."""

from pathlib import Path

import numpy as np
import pytest
from fmpy.util import read_csv
from lxml import etree, html

from stickslip import models
from stickslip.fmi import toolchain
from stickslip.fmi.binary import read_library
from stickslip.fmi.toolchain import PLATFORMS
from stickslip.models.export.package import blank_library
from stickslip.models.export.presentation import reference_file
from stickslip.models.export.sources import START, fmi_headers, grouped, start_source
from tests.cosim.single import by_fmpy, members

ROOT = Path(models.__file__).parent.parent
LS_REF = "extra/org.fmi-standard.fmi-ls-ref"


def test_the_sources_are_those_of_the_binary(some_fmu):
    """They are compiled as is stated there; some, again with their start values, to the bytes."""
    content = members(some_fmu.path)
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

    def compiled(name, start):
        files, common = grouped(own | start)
        return toolchain.shared_library(
            name, files | system, common=common, flags=flags, standalone=True
        )

    host, count = toolchain.host_platform(), len(some_fmu.model.variables)
    blank = compiled("model", {START: start_source("", [0.0] * count)})
    assert blank == blank_library(some_fmu.model, some_fmu.version, host)  # its place tells of what
    if some_fmu.target in ("stage", "dob", "drive"):
        [binary] = [path for path in content if path.startswith("binaries/")]
        assert compiled(some_fmu.model.name, {}).read_bytes() == content[binary]


def test_the_documentation_is_the_readme(some_fmu):
    content = members(some_fmu.path)
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
    **{f"{name}_observer": {"F": 1e-8, "a_hat": 1e-8} for name in ("coulomb", "momentum")},
    "dob": {"F": 1e-8, "d_hat": 1e-8},
    "lugre_observer": {"F": 1e-8, "z_hat": 1e-14},
    **{f"command_{name}": {"F_ff": 1e-12, "v_r": 1e-15} for name in ("feedforward", "static")},
    **{name: {"F": 1e-9} for name in ("adaptive_scale", "lffc", "lugre_network", "rbf", "mlp")},
}


def test_the_reference_inside_is_met(fmu, tmp_path):
    if reference_file(fmu.model) is None:
        pytest.skip("the reference of a plant is for its default law")
    content = members(fmu.path)
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
    how = {"input": stimuli, "step_size": step}
    found = by_fmpy(fmu.path, step, stop, *fmu.names("output"), **how)
    assert set(expected.dtype.names) == {"time", *fmu.names("output")}
    for name in fmu.names("output"):
        tolerance = TOLERANCE.get(fmu.model.name, {}).get(name, 1e-12)
        assert np.ptp(expected[name]) > 100 * tolerance
        np.testing.assert_allclose(
            found[name], expected[name], rtol=0.0, atol=tolerance, err_msg=name
        )


def test_other_start_values_have_no_reference_inside(tmp_path):
    built = members(models.build_fmu("stage", tmp_path, start={"m": 2.0}))
    assert not [name for name in built if name.startswith("extra/")]


SYSTEM = {"libc.so.6", "KERNEL32.dll", "/usr/lib/libSystem.B.dylib"}
FOLDERS = {
    2: {"linux64": "so", "aarch64-linux": "so", "win64": "dll", "darwin64": "dylib"},
    3: {name: p.suffix[1:] for name, p in PLATFORMS.items()},
}


@pytest.mark.parametrize("version", [2, pytest.param(3, marks=pytest.mark.thorough)])
def test_one_fmu_holds_all_platforms(version, tmp_path):
    """In FMI 2.0 both processors of macOS share one universal library."""
    fmu = models.build_fmu("stage", tmp_path, fmi=version, platforms=PLATFORMS.values())
    libraries = {name: x for name, x in members(fmu).items() if name.startswith("binaries/")}
    expected = {f"binaries/{folder}/stage.{end}" for folder, end in FOLDERS[version].items()}
    assert set(libraries) == expected
    if version == 2:
        assert libraries.pop("binaries/darwin64/stage.dylib")[:4] == b"\xca\xfe\xba\xbe"
    for library in libraries.values():
        found = read_library(library)
        assert set(found.needs) <= SYSTEM
        assert f"fmi{version}DoStep" in found.exports
