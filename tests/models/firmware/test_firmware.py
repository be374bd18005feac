"""The compensator as C and as structured text, against its FMU over a command."""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from stickslip import cosim, models
from stickslip.fmi import toolchain
from stickslip.models.firmware import write_compensator

sys.path.insert(0, str(Path(__file__).parent))  # structured_text
import structured_text

STEP = 5e-4  # s
TUNED = {"F_s": 8.91, "F_c": 6.0002185, "v_s": 5.627e-4, "sigma_0": 3.9298e5, "sigma_1": 4436.34}
ASKED = ("-Wall", "-Wextra", "-Werror", "-std=c99", "-pedantic")
STRICT = ("-Wconversion", "-Wfloat-conversion", "-Wdouble-promotion", "-ffreestanding", "-O2")
# hold, lead [s], b [N s/m], delta
SETTINGS = [(1, 0.0, 0.0, 1.0), (0, 1e-4, 0.0, 1.0), (1, 0.0, 6.6, 2.0), (0, 2e-4, 3.0, 0.7)]


def command(n: int = 2001) -> np.ndarray:
    """Return a velocity [m/s] that rests, creeps, reverses and runs fast."""
    t = np.arange(n) * STEP
    v = 0.04 * np.sin(40 * t) * np.cos(3 * t) + 2e-4 * np.sin(7 * t)
    return np.where(t < 0.01, 0.0, v)


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("exported")
    for language in ("c", "st"):
        write_compensator(folder, language, start=TUNED)
    models.build_fmu("compensator", folder, start=TUNED)
    return folder


@pytest.fixture(scope="module")
def forces(exported: Path):
    """Return what the FMU gives: ``forces(settings)``, F_mean and F_f after each step, (n, 2)."""

    def run(settings: tuple[float, ...]) -> np.ndarray:
        system = cosim.System()
        hold, lead, b, delta = settings
        parameters = {"hold": bool(hold), "lead": lead, "b": b, "delta": delta}
        system.add("c", exported / "compensator.fmu", parameters)
        system.expose("v", "c.v")
        with system.prepare(step=STEP, stop=1.0, constant_step=True) as simulation:
            result = simulation.run(inputs={"v": command()})
        return np.column_stack([result["c.F_mean"], result["c.F_f"]])[1:]

    return run


def driven(exported: Path, settings: tuple[float, ...], *flags: str) -> np.ndarray:
    files = {name: (exported / name).read_text() for name in ("compensator.c", "compensator.h")}
    files["driver.c"] = Path(__file__).with_name("driver.c").read_text()
    flags = ("-Wno-conversion", *ASKED, *flags)
    library = ctypes.CDLL(str(toolchain.shared_library("firmware", files, flags=flags)))
    library.drive.restype = ctypes.c_size_t
    v, force = command()[:-1], np.empty((2000, 2))
    finite = library.drive(
        ctypes.c_size_t(2000),
        ctypes.c_double(STEP),
        v.ctypes.data_as(ctypes.c_void_p),
        (ctypes.c_double * 4)(*settings),
        force.ctypes.data_as(ctypes.c_void_p),
    )
    assert finite == 2000
    return force


@pytest.mark.parametrize("settings", SETTINGS, ids=str)
def test_c_in_double_is_the_fmu_bit_for_bit(exported, forces, settings):
    np.testing.assert_array_equal(driven(exported, settings), forces(settings))


@pytest.mark.parametrize("settings", SETTINGS, ids=str)
def test_c_in_float_is_within_its_rounding(exported, forces, settings):
    """Forces reach 60 N, of which a bit is 4e-6 N."""
    expected = forces(settings)
    force = driven(exported, settings, "-DCOMPENSATOR_FLOAT")
    assert np.abs(force - expected).max() < 1e-4  # N
    assert np.abs(force - expected).max() > 0.0  # float was compiled indeed


def test_exp_and_log_in_float_are_within_two_bits():
    """Their header claims a relative error below 2e-7; a bit of a float is 6e-8 to 1.2e-7."""
    visible = '__attribute__((visibility("default"))) '
    export = "__declspec(dllexport) " if sys.platform == "win32" else visible
    source = '#include "single.h"\n' + "\n".join(
        f"{export}float probe_{name}(float x);\n"
        f"{export}float probe_{name}(float x) {{ return elementary_{name}(x); }}"
        for name in ("exp", "log", "sin")
    )
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


@pytest.mark.parametrize("flags", [(), ("-DCOMPENSATOR_FLOAT",)], ids=str)
def test_strict_compilers_of_c99_have_nothing_to_say(exported, flags, tmp_path):
    compiler = [sys.executable, "-m", "ziglang", "cc"]
    for called in (compiler, ["gcc"])[: 1 + bool(shutil.which("gcc"))]:
        target = tmp_path / "compensator.o"
        arguments = [*called, *ASKED, *STRICT, *flags, "-c", "compensator.c", "-o", str(target)]
        done = subprocess.run(arguments, cwd=exported, capture_output=True, text=True)
        assert (done.returncode, done.stderr) == (0, "")


def test_c_includes_what_freestanding_targets_have(exported):
    """C99, section 4: a freestanding implementation has these and no <string.h>."""
    freestanding = ["float", "iso646", "limits", "stdarg", "stdbool", "stddef", "stdint"]
    for name in ("compensator.c", "compensator.h"):
        included = re.findall(r"#include <(\w+)\.h>", (exported / name).read_text())
        assert {*included} <= {*freestanding}
    assert "memcpy" not in (exported / "compensator.c").read_text()


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


def test_c_keeps_nothing_between_calls_and_allocates_nothing(exported):
    text = (exported / "compensator.c").read_text()
    assert not any(word in text for word in ("malloc", "math.h", "while", "goto"))
    outside = [line for line in text.splitlines() if line.startswith("static ")]
    assert outside
    assert all("(" in line for line in outside)  # functions, no variables


@pytest.mark.parametrize("settings", SETTINGS, ids=str)
def test_structured_text_agrees_with_the_fmu(exported, forces, settings):
    block = structured_text.load((exported / "compensator.st").read_text())["Compensator"]
    hold, lead, b, delta = settings
    expected = forces(settings)
    result = np.empty_like(expected)
    for n, v in enumerate(command()[:-1]):
        scope = block(h=STEP, v=float(v), hold=bool(hold), lead=lead, b=b, delta=delta)
        result[n] = scope["F_mean"], scope["F_f"]
        assert scope["valid"]
    np.testing.assert_allclose(result, expected, rtol=0, atol=1e-10)


def test_structured_text_refuses_a_cycle_without_time(exported):
    block = structured_text.load((exported / "compensator.st").read_text())["Compensator"]
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
