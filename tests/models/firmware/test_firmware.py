"""The compensator of the paper as C and as structured text: what controllers ask of the code."""

import ctypes
import re
from pathlib import Path

import numpy as np
import pytest

from stickslip import models
from stickslip.fmi import toolchain
from stickslip.models.firmware import write_compensator
from tests.corpus.fmu import EXPORT
from tests.models.firmware import structured_text

STEP = 5e-4  # s
TUNED = {"F_s": 8.91, "F_c": 6.0002185, "v_s": 5.627e-4, "sigma_0": 3.9298e5, "sigma_1": 4436.34}


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("exported")
    for language in ("c", "st"):
        write_compensator(folder, language, start=TUNED)
    return folder


def test_exp_and_log_in_float_are_within_two_bits():
    """Their header claims a relative error below 2e-7; a bit of a float is 6e-8 to 1.2e-7."""
    source = f'{EXPORT}#include "single.h"\n' + "\n".join(
        f"EXPORT float probe_{name}(float x);\n"
        f"EXPORT float probe_{name}(float x) {{ return elementary_{name}(x); }}"
        for name in ("exp", "log", "sin")
    )
    source += "\nEXPORT int probe_nearest(float x);\n"
    source += "EXPORT int probe_nearest(float x) { return (int)nearest(x); }"
    header = Path(models.__file__).with_name("firmware") / "single.h"
    files = {"probe.c": source, "single.h": header.read_text()}
    library = ctypes.CDLL(str(toolchain.shared_library("single", files)))
    for name, x, near in (
        ("exp", np.linspace(-87, 88, 3000), 0.0),
        ("log", np.geomspace(1e-37, 1e38, 3000), 0.0),
        ("sin", np.linspace(-10, 10, 3000), 2e-7),
    ):
        function = getattr(library, f"probe_{name}")
        function.restype = ctypes.c_float
        x = x.astype(np.float32)
        found = [function(ctypes.c_float(value)) for value in x]
        np.testing.assert_allclose(found, getattr(np, name)(x.astype(float)), rtol=2e-7, atol=near)
    assert library.probe_exp(ctypes.c_float(-88.0)) == 0.0
    nearest = [library.probe_nearest(ctypes.c_float(x)) for x in (-2.6, -2.4, 0.2, 1e6)]
    assert nearest == [-3, -2, 0, 1_000_000]


def test_c_includes_what_freestanding_targets_have_and_keeps_nothing(exported):
    """C99, section 4: a freestanding implementation has these and no <string.h>."""
    freestanding = ["float", "iso646", "limits", "stdarg", "stdbool", "stddef", "stdint"]
    for name in ("compensator.c", "compensator.h"):
        included = re.findall(r"#include <(\w+)\.h>", (exported / name).read_text())
        assert {*included} <= {*freestanding}
    text = (exported / "compensator.c").read_text()
    assert not any(word in text for word in ("memcpy", "malloc", "while", "goto"))
    outside = [line for line in text.splitlines() if line.startswith("static ")]
    assert outside
    assert all("(" in line for line in outside)  # functions, no variables


@pytest.mark.parametrize(
    ("name", "inputs"),
    [
        ("dob", ["x_enc", "F_m", "v_r", "F_in"]),
        ("lffc", ["v_r", "u", "F_in"]),
        ("lugre_observer", ["x_enc", "v_r", "F_in"]),
    ],
)
def test_arguments_of_c_keep_their_order(tmp_path, name, inputs):
    """Firmware calls these functions, and a compiler does not notice two that are swapped."""
    header, _ = write_compensator(tmp_path, "c", model=name)
    declared = re.search(rf"{name}_init\((.*)\);", header.read_text())[1]
    assert re.findall(rf", {name}_real (\w+)", declared) == inputs


def test_c_of_a_plant_has_all_that_it_calls(tmp_path):
    _, source = write_compensator(tmp_path, "c", model="drive")
    assert "law_scaled(const Law *p, real factor) {" in source.read_text()


@pytest.mark.parametrize("start", [{}, {"b": 1e-300, "lead": 5e-324, "F_s": 1e9, "delta": 0.5}])
def test_literals_of_structured_text_are_in_the_range_of_real(tmp_path, start):
    """IEC 61131-3: a literal without a type may be REAL, of 32 bits; matiec refuses others."""
    (path,) = write_compensator(tmp_path, "st", start=TUNED | start)
    code = re.sub(r"\(\*.*?\*\)", "", path.read_text(), flags=re.DOTALL)
    literals = [float(word) for word in re.findall(r"\d+\.\d+(?:E[+-]?\d+)?", code)]
    limits = np.finfo(np.float32)
    assert len(literals) > 20
    assert all(x == 0.0 or limits.tiny <= x <= limits.max for x in literals)


def test_structured_text_computes_with_any_ratio_of_speeds(tmp_path):
    """Also where |v| / v_s is below what a REAL or a normal number holds: next to no force."""
    (path,) = write_compensator(tmp_path, "st", start=TUNED)
    block = structured_text.load(path.read_text())["Compensator"]
    for v in (0.0, 5e-324, 1e-310, 1e-300, 1e-40, 1e-12):
        for delta in (0.1, 0.5, 1.0, 2.0, 10.0):
            scope = block(h=STEP, v=v, delta=delta)
            assert scope["valid"]
            assert 0.0 <= scope["F_mean"] < 1e-3


def test_structured_text_refuses_a_cycle_without_time(exported):
    text = (exported / "compensator.st").read_text()
    assert "in  v: [m/s" in text[: text.index("TYPE")]
    assert "out F_mean: [N" in text[: text.index("TYPE")]
    block = structured_text.load(text)["Compensator"]
    assert block(h=STEP, v=0.01)["valid"]
    before = dict(block.variables)
    assert not block(h=0.0, v=0.02)["valid"]
    assert block.variables == {**before, "h": 0.0, "v": 0.02, "valid": False}


def test_the_interpreter_is_as_strict_as_a_controller():
    head = "FUNCTION f : LREAL VAR k : INT; END_VAR"
    for wrong in ("f := 1;", "f := 1.0 + k;", "g := 1.0;", "f := EXP(k);", "k := 1.0;"):
        with pytest.raises((AssertionError, KeyError)):
            structured_text.load(f"{head} {wrong} END_FUNCTION")["f"]()
    twice = "FUNCTION f : LREAL VAR a : INT; A : INT; END_VAR f := 1.0; END_FUNCTION"
    with pytest.raises(AssertionError):
        structured_text.load(twice)


def test_start_values_outside_their_range_are_told(tmp_path):
    with pytest.raises(models.StartValueError, match=r"F_c = -1 N is outside 1e-15 \.\. 1e\+15 N"):
        write_compensator(tmp_path, "c", start={"F_c": -1.0})
