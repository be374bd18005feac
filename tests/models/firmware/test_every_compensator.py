"""Each compensator and friction law as C and structured text, against its FMU step by step."""

import ctypes
import shutil
import subprocess
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from stickslip import models
from stickslip.fmi import toolchain
from stickslip.models.firmware import c_files, write_compensator
from stickslip.models.firmware.structured_text import st_text
from stickslip.servo.axis import Axis
from stickslip.servo.systems import loop_values
from stickslip.servo.velocity_loop import close_velocity_loop
from tests.cosim.single import exposed
from tests.kept import further
from tests.models.firmware import structured_text

STEP, N = 5e-4, 1500  # s
STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-Wconversion", "-ffreestanding")
STRICT += ("-Wfloat-conversion", "-Wdouble-promotion")
FEEDFORWARDS = {law: ("compensator", law, "compensator") for law in models.law_names()}
OBSERVER = ("dob", None, "observer")
OTHERS = {
    name: (name, None, None)
    for name in models.model_names()
    if models.load_model(name).ports and name not in ("compensator", "dob")
}
DEPLOYED = {
    "command_lugre": ("command_feedforward", "lugre", "command_feedforward"),
    "command_gms": ("command_feedforward", "gms", "command_feedforward"),
    "command_static": ("command_static", None, None),
}
POSITION = ("position_force", None, None)
CASES = {**FEEDFORWARDS, **DEPLOYED, "observer": OBSERVER, **OTHERS, "position_force": POSITION}
LOOP = loop_values(
    close_velocity_loop(Axis(5.0, 6.0, 1e-4), STEP, STEP, 4e3, 3e4, m_ff=5.0, K_x=40.0)
)
STARTS = {
    **{case: {**LOOP, "lead": 1e-4} for case in DEPLOYED},
    "dahl": {"i": 0.7},
    "lugre": {"v_d": 5e-3, "lead": 1e-4, "delta": 0.7, "hold": 0.0, "b": 3.0},
    "elasto_plastic": {"delta": 2.0, "b": 6.6},
    "gms": {"F_s": 9.5, "C": 800.0, "delta": 2.0},
    "coulomb_stribeck": {"F_s": 9.5, "delta": 0.7, "b": 3.0, "lead": 1e-4, "hold": 0.0},
    "coulomb_observer": {"k_a": 0.2, "a_0": 3.0, "measured": 1.0},
    "momentum_observer": {"mu": 1.5, "a_0": 3.0, "share": 0.8},
    "position_force": {"g_c": 3.0, "pitch": 2e-3, "cogging_s[2]": 1.0, "cogging_c[1]": -2.0},
    "adaptive_scale": {"s_0": 1.3, "rate": 20.0, "b": 0.0},
    "lugre_observer": {"share_1": 0.3, "v_d": 5e-3, "k_e": 0.6},
    "observer": {"m": 2.0, "b": 30.0, "tau_i": 4e-4, "L_v": 300.0, "share": 0.8},
}


def signals(names: list[str]) -> dict[str, np.ndarray]:
    """Return inputs (N,) of a motion that rests, creeps, reverses and runs fast."""
    t = np.arange(N) * STEP
    v = np.where(t < 0.01, 0.0, 0.04 * np.sin(40 * t) * np.cos(3 * t) + 2e-4 * np.sin(7 * t))
    x = np.round(np.cumsum(v) * STEP / 4e-7) * 4e-7
    F = 8.0 * np.tanh(v / 1e-3) + 3.0 * np.gradient(v, STEP)
    found = {"v_cmd": v, "x_cmd": np.cumsum(v) * STEP, "a_cmd": np.gradient(v, STEP)}
    found |= {"v": v, "v_r": v, "x": x, "x_enc": x}
    found |= {"F_m": F, "F_in": 5.0 * np.tanh(v / 2e-3), "u": 2.0 * F}
    return {name: found[name] for name in names}


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """Return a function: case -> folder with C, structured text and FMU."""

    @cache
    def export(case: str) -> Path:
        model, law, called = CASES[case]
        folder = tmp_path_factory.mktemp(case)
        start = STARTS.get(case, {})
        for language in ("c", "st"):
            write_compensator(folder, language, start=start, law=law, model=model, called=called)
        models.build_fmu(model, folder, start=start, law=law, called=called)
        return folder

    return export


def of_fmu(folder: Path, case: str, n: int = N - 1) -> tuple[models.Model, np.ndarray, list[float]]:
    """Return the model, its outputs (n, outputs) after each step, and what it has learned."""
    model, law, called = CASES[case]
    found = models.load_model(model, law)
    found = replace(found, name=called or found.name)
    inputs, outputs = members(found, "input"), members(found, "output")
    system = exposed(folder / f"{found.name}.fmu", name="c")
    given = {name: values[: n + 1] for name, values in signals(inputs).items()}
    with system.prepare(step=STEP, stop=n * STEP, constant_step=True) as simulation:
        result = simulation.run(inputs=given)
        columns = np.column_stack([result[f"c.{name}"] for name in outputs])[1:].copy()
        return found, columns, [*simulation.learned().values()]


LEARNED = {
    name: next(iter(ports.learned.values())).partition("[")[0]
    for name in OTHERS
    if (ports := models.load_model(name).ports) and ports.learned
}
"""Members of the memory that are learned."""


def members(model: models.Model, role: str) -> list[str]:
    return [name for name, _ in model.fields[role]]


def driver(model: models.Model) -> str:
    """Return C that feeds rows of inputs to a model and writes rows of outputs."""
    name = model.name
    struct = "".join(word.capitalize() for word in name.split("_"))
    inputs, outputs = members(model, "input"), members(model, "output")
    given = "".join(f", ({name}_real)in[i * {len(inputs)} + {k}]" for k in range(len(inputs)))
    kept = "".join(
        f"        out[i * {len(outputs)} + {k}] = (double)c.outputs.{output};\n"
        for k, output in enumerate(outputs)
    )
    step = "" if model.sampled else f", ({name}_real)h"
    learned = f"&c.memory.{LEARNED[name]}" if name in LEARNED else "NULL"
    size = learned.replace("&", "sizeof ").replace("NULL", "0")
    return f"""
#include <stddef.h>
#include "{name}.h"
__attribute__((visibility("default")))
size_t drive(size_t n, double h, const double *in, double *out, double *learned);
size_t drive(size_t n, double h, const double *in, double *out, double *learned) {{
    {struct} c;
    const {name}_real *memory = (const {name}_real *){learned};
    size_t finite = 0, i = 0;
    (void)h;
    {name}_init(&c{given});
    for (; i < n; i++) {{
        finite += {name}_step(&c{step}{given});
{kept}    }}
    for (i = 0; memory && i < {size} / sizeof *memory; i++)
        learned[i] = (double)memory[i];
    return finite;
}}
"""


def of_c(folder: Path, model: models.Model, *flags: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the outputs (N - 1, outputs) of the C, and what it has learned, with zeros behind."""
    files = {f"{model.name}.{end}": (folder / f"{model.name}.{end}").read_text() for end in "ch"}
    files["driver.c"] = driver(model)
    library = ctypes.CDLL(str(toolchain.shared_library("every", files, flags=(*STRICT, *flags))))
    library.drive.restype = ctypes.c_size_t
    given = np.column_stack([*signals(members(model, "input")).values()])[:-1].copy()
    out = np.empty((N - 1, len(members(model, "output"))))
    learned = np.zeros(200)
    pointers = [array.ctypes.data_as(ctypes.c_void_p) for array in (given, out, learned)]
    count = library.drive(ctypes.c_size_t(N - 1), ctypes.c_double(STEP), *pointers)
    assert count == N - 1
    return out, learned


FLOATS = [*FEEDFORWARDS, "observer", "momentum_observer", "mlp", "lugre_network", "position_force"]
"""Those whose C in float is compiled in every run of the tests."""


@pytest.mark.parametrize("case", CASES)
def test_c_in_double_is_the_fmu_bit_for_bit_and_structured_text_agrees(exported, case):
    folder = exported(case)
    model, expected, learned = of_fmu(folder, case)
    found, memory = of_c(folder, model)
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(memory[: len(learned)], learned)
    assert np.ptp(expected) > 5.0  # N
    blocks = structured_text.load((folder / f"{model.name}.st").read_text())
    block = blocks[model.name.capitalize()]
    given = signals(members(model, "input"))
    outputs = members(model, "output")
    step = {} if model.sampled else {"h": STEP}
    for k in range(200):  # they rest, creep and reverse
        scope = block(**step, **{name: float(values[k]) for name, values in given.items()})
        assert scope["valid"]
        found = [scope[name] for name in outputs]
        np.testing.assert_allclose(found, expected[k], rtol=0, atol=1e-7)
    if case in LEARNED:  # a member of the memory, from which the next function block begins
        shown = next(scope[key] for key in (LEARNED[case], f"{LEARNED[case]}_1") if key in scope)
        _, _, learned = of_fmu(folder, case, 200)
        np.testing.assert_allclose(np.ravel(shown), learned, rtol=1e-9, atol=1e-9)


@pytest.mark.skipif(shutil.which("g++") is None, reason="g++ is not installed here")
def test_c_is_valid_cpp_and_states_its_formulas(tmp_path):
    sources = []
    for case, (model, law, _) in CASES.items():
        for name, text in c_files(models.load_model(model, law)).items():
            (tmp_path / case).mkdir(exist_ok=True)
            (tmp_path / case / name).write_text(text)
        sources.append(tmp_path / case / f"{model}.c")
        header = (tmp_path / case / f"{model}.h").read_text()
        assert " = " in header.partition("*/")[0]
        assert "equation (" not in header
    strict = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"]
    compiler = ["g++", "-x", "c++", "-std=c++11", "-fsyntax-only"]
    subprocess.run([*compiler, *strict, *map(str, sources)], check=True)


@pytest.mark.parametrize("case", [*FLOATS, *further(*(c for c in CASES if c not in FLOATS))])
def test_c_in_float_is_near(exported, case):
    """The observer's position has 24 bits, of which one is worth some newtons in L_d."""
    folder = exported(case)
    model, expected, _ = of_fmu(folder, case)
    found, _ = of_c(folder, model, "-DSTICKSLIP_FLOAT")
    error = np.abs(found - expected)
    assert error.max() > 0.0  # float was compiled indeed
    assert np.sqrt(np.mean(error**2)) < 0.02 * np.ptp(expected)


def test_what_structured_text_has_not_is_refused(tmp_path):
    with pytest.raises(models.ModelError, match="is not available in structured text"):
        write_compensator(tmp_path, "st", model="stage")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("statement", "reason"),
    [
        ("do { w->v_last = u->v; } while (h < 0.0);", "model_step: cannot translate 'do {"),
        ("goto end; end: w->v_last = u->v;", "model_step: cannot translate 'goto end;'"),
        ("w->v_last = *(&u->v + 1);", r"model_step: cannot translate '\*\(\(&u->v\) \+ 1\)'"),
        ("w->v_last = fabs(u->v);", "model_step: fabs is not known"),
        ("static double kept = 0.0;", "model_step: cannot translate 'static double kept = 0.0'"),
        ("while (h > 0.0 ? 1 : 0) h -= 1.0;", "the condition of a loop has a choice in it"),
        (
            "while (h > 0.0) { if (h > 1.0) { if (h > 2.0) continue; } w->v_last = h; }",
            "continue is inside of an if that more follows",
        ),
        ("uint64_t bits = 0;", "cannot translate the type 'uint64_t'"),
        ("w->v_last = (;", "cannot read "),
    ],
)
def test_a_refusal_tells_what_structured_text_has_not(tmp_path, statement, reason):
    model = models.load_model("static_feedforward")
    code = (model.folder / "model.c").read_text()
    assert "w->v_last = u->v;" in code
    (tmp_path / "model.c").write_text(code.replace("w->v_last = u->v;", statement))
    with pytest.raises(models.ModelError, match=reason):
        st_text(replace(model, folder=tmp_path))


def test_a_loop_counts_only_where_c_does(tmp_path):
    """FOR has a fixed bound and a step of 1; other loops become WHILE."""
    model = models.load_model("static_feedforward")
    code = (model.folder / "model.c").read_text()
    shutil.copy(model.folder / "README.md", tmp_path)  # the header states its equations
    for loop, shown in (
        ("int i = 0; i < 9; i++", "FOR i := 0 TO 8 DO"),
        ("int i = 9; i >= 2; i--", "FOR i := 9 TO 2 BY -1 DO"),
        ("int i = 0; i < 9; i += 2", "WHILE i < 9 DO"),
        ("int i = 9; i < 9; i--", "WHILE i < 9 DO"),
    ):
        loops = f"for ({loop}) w->v_last = u->v;"
        (tmp_path / "model.c").write_text(code.replace("w->v_last = u->v;", loops))
        assert shown in st_text(replace(model, folder=tmp_path))
