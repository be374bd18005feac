"""The exported compensator, connected as docs/deploying.md prints it, in loops of each kind.

The claim is that of the trial: its loop of FMUs, in which the compensator takes the velocity of the
nominal loop. The block under test takes the commands alone.
"""

import ctypes
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stickslip import cosim, models
from stickslip.evaluation.motions import VALIDATION
from stickslip.fmi import toolchain
from stickslip.models.firmware import write_combined, write_compensator
from stickslip.servo.axis import Axis
from stickslip.servo.systems import Compensator, build_fmus, build_loop, deployed
from stickslip.servo.velocity_loop import (
    LoopSpecification,
    close_velocity_loop,
    design_velocity_loop,
)
from stickslip.trial.family import commands
from tests.cosim.single import exposed
from tests.kept import further
from tests.models.firmware import structured_text

ROOT = Path(__file__).parents[3]
T_S = 5e-4  # s
GUIDE = (ROOT / "docs" / "deploying.md").read_text(encoding="utf-8")
AXIS = Axis(1.0, 2.0, 1e-4)
FRICTION = {"F_c": 2.0, "F_s": 3.0, "v_s": 1e-3, "sigma_0": 1e5, "sigma_1": 500.0}
FEEDFORWARDS = {
    "compensator": FRICTION,
    "static_feedforward": {"F_c": 2.0, "v_t": 1e-4, "asymmetry": 0.0, "b": 0.0, "lead": 1e-4},
}
LOOPS = {
    "velocity": {},
    "inertia": {"m_ff": 1.0},
    "position": {"K_x": 40.0, "velocity_feedforward": 0.0},
    "both": {"K_x": 40.0, "velocity_feedforward": 0.6},
}
COMMANDS = {one.name: one.v_cmd for one in commands(VALIDATION, T_S, FRICTION, 4e-7)[4:0:-1]}
SIGNALS = {"fSetVelocity": "v_cmd", "fSetPosition": "x_cmd"}  # of the axis, in structured text


def closed(kind):
    inner = design_velocity_loop(AXIS, LoopSpecification(80.0, 50.0, T_S, T_S))
    return close_velocity_loop(AXIS, T_S, T_S, inner.K_p, inner.K_i, **LOOPS[kind])


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fmus")
    names = ("drive", "velocity_controller", "nominal_loop", "dob", *FEEDFORWARDS)
    build_fmus(folder, {**AXIS.of_drive(), **FRICTION}, only=names)
    return folder


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """Return a function: model of the feedforward, kind of loop -> folder with FMU, C and text."""

    def export(model, kind):
        folder = tmp_path_factory.mktemp("exported")
        one = deployed(Compensator("compensator", model, FEEDFORWARDS[model]), closed(kind), T_S)
        named = {"start": one.values, "called": "compensator"}
        models.build_fmu(one.model, folder, **named)
        for language in ("c", "st"):
            write_compensator(folder, language, model=one.model, **named)
        return folder

    return export


def signals(loop, v_cmd):
    """Return what the controller has: its commands, those that it has not 0."""
    return dict.fromkeys(("v_cmd", "x_cmd", "a_cmd"), np.zeros(len(v_cmd))) | loop.commands(v_cmd)


def errors(fmus, loop, v_cmd, force):
    """Return the errors [m/s] and [m] against the motion without friction under a force [N]."""
    system = build_loop(fmus, loop, [])
    system.expose("F", "controller.F_ff")
    return missed(system, loop, v_cmd, F=force)


def missed(system, loop, v_cmd, **inputs):
    stop, record = (len(v_cmd) - 1) * T_S, ("drive.x", "drive.v")
    with system.prepare(step=T_S, stop=stop, record=record, constant_step=True) as simulation:
        found = simulation.run({}, loop.commands(v_cmd) | inputs)
    v, x = loop.response(v_cmd)
    v = np.append(0.0, v[:-1])  # the velocity of the loop at the end of each period
    return [np.sqrt(np.mean((found[f"drive.{n}"] - r) ** 2)) for n, r in (("v", v), ("x", x))]


def by_c(folder, given):
    """Return the force by the C of the guide."""
    code = re.search(r"^ {4}#include.*?^ {4}}\n\n {4}double.*?^ {4}}$", GUIDE, re.M | re.S)[0]
    flags = ("-Wall", "-Wextra", "-Werror", "-std=c99")
    files = {f"compensator.{end}": (folder / f"compensator.{end}").read_text() for end in "ch"}
    files["guide.c"] = f"#pragma GCC visibility push(default)\n{code}\n"
    library = ctypes.CDLL(str(toolchain.shared_library("guide", files, flags=flags)))
    library.added_force.restype = ctypes.c_double
    rows = [
        [*map(ctypes.c_double, row)] for row in zip(given["v_cmd"], given["x_cmd"], strict=True)
    ]
    library.start(*rows[0])
    return np.array([library.added_force(*row) for row in rows])


def by_structured_text(folder, given):
    """Return the force by the call that the guide prints."""
    call = re.search(r"^ +friction\((.*)\); \(\*", GUIDE, re.M)[1]
    inputs = dict(re.findall(r"(\w+) := (\w+)", call))
    output = re.search(r":= friction\.(\w+);", GUIDE)[1]
    block = structured_text.load((folder / "compensator.st").read_text())["Compensator"]
    force = []
    for k in range(len(given["v_cmd"])):
        scope = block(**{name: float(given[SIGNALS[source]][k]) for name, source in inputs.items()})
        assert scope["valid"]
        force.append(scope[output])
    return np.array(force)


def by_fmu(folder, given):
    """Return the force by the FMU, connected as the table of the guide says."""
    inputs = re.findall(r"^\| `(\w+)` \| .* \| .* \|$", GUIDE, re.M)[:3]
    system = exposed(folder / "compensator.fmu", name="c")
    n = len(given["v_cmd"])
    inputs = {name: np.append(given[name], given[name][-1]) for name in inputs}
    with system.prepare(step=T_S, stop=n * T_S, constant_step=True) as simulation:
        return simulation.run(inputs=inputs)["c.F_ff"][1:].copy()


CASES = [
    ("compensator", "velocity", 0.05),
    ("compensator", "both", 0.1),
    ("static_feedforward", "velocity", 0.6),
    *further(("compensator", "position", 0.1)),
]
"""Feedforward, loop, and share of the position error of the loop that is left."""


@pytest.mark.parametrize(("model", "kind", "left"), CASES)
def test_the_code_of_the_guide_reduces_the_error_as_in_the_trial(fmus, exported, model, kind, left):
    loop, folder = closed(kind), exported(model, kind)
    tried = build_loop(fmus, loop, [Compensator("compensator", model, FEEDFORWARDS[model])])
    for name in ("4 mm/s", "micro-steps"):
        v_cmd = COMMANDS[name]
        given = signals(loop, v_cmd)
        force = by_c(folder, given)
        np.testing.assert_array_equal(by_fmu(folder, given), force)
        without, found = (errors(fmus, loop, v_cmd, k * force) for k in (0.0, 1.0))
        assert found == pytest.approx(missed(tried, loop, v_cmd), rel=1e-6)
        assert found[1] < left * without[1]
    part = slice(600)  # of the micro-steps: starts and reverses
    text = by_structured_text(folder, {key: one[part] for key, one in given.items()})
    np.testing.assert_allclose(text, force[part], rtol=0, atol=1e-9)


def test_all_commands_of_the_controller_are_taken(fmus, exported):
    """With feedforward of inertia, whose acceleration the code of the guide does not have."""
    loop, v_cmd = closed("inertia"), COMMANDS["micro-steps"]
    force = by_fmu(exported("compensator", "inertia"), signals(loop, v_cmd))
    tried = build_loop(fmus, loop, [Compensator("compensator", "compensator", FRICTION)])
    assert errors(fmus, loop, v_cmd, force) == pytest.approx(missed(tried, loop, v_cmd), rel=1e-6)


def test_without_a_loop_the_force_is_that_of_the_velocity_command(tmp_path):
    block = deployed(Compensator("compensator", "compensator", FRICTION), None, T_S)
    models.build_fmu(block.model, tmp_path, start=block.values, called="compensator")
    v_cmd = COMMANDS["micro-steps"]
    given = {"v_cmd": v_cmd, "x_cmd": np.cumsum(v_cmd), "a_cmd": v_cmd}
    system = cosim.System()
    system.add("law", models.build_fmu("compensator", tmp_path, called="law", start=FRICTION))
    system.expose("v", "law.v")
    system.set("law.hold", False)
    stop = (len(v_cmd) - 1) * T_S
    with system.prepare(step=T_S, stop=stop, constant_step=True) as simulation:
        expected = simulation.run(inputs={"v": v_cmd})["law.F_mean"][1:]
    np.testing.assert_array_equal(by_fmu(tmp_path, given)[:-1], expected)


def test_the_call_of_the_guide_adds_the_force_of_the_chain(fmus, tmp_path):
    """Both in C, called as the guide prints it, with the signals of the loop with the drive."""
    loop, v_cmd = closed("both"), COMMANDS["micro-steps"]
    chain = [
        Compensator("compensator", "compensator", FRICTION),
        Compensator("observer", "dob", {"share": 0.5, "onset": 2e-6}),
    ]
    one = deployed(chain[0], loop, T_S)
    blocks = {one.model: one.values, "dob": chain[1].parameters(loop)}
    paths = write_combined(
        tmp_path,
        "c",
        [
            replace(models.load_model(model).with_start(start), name=part.name)
            for (model, start), part in zip(blocks.items(), chain, strict=True)
        ],
    )
    static, begin, body = re.search(
        r"^ {4}(static AddedForce .*;) /\* once at the start: (.*) \*/\n\n(.*?)\n\n",
        GUIDE,
        re.M | re.S,
    ).groups()
    code = f"""#include "added_force.h"
{static}
static const double a_cmd = 0.0, gain = 1.0;
void start(double v_cmd, double x_cmd, double x_enc, double F_m) {{ {begin}; }}
double both(double v_cmd, double x_cmd, double x_enc, double F_m) {{
    double output = 0.0;
{body}
    return output;
}}
"""
    files = {path.name: path.read_text() for path in paths}
    files["guide.c"] = f"#pragma GCC visibility push(default)\n{code}\n"
    library = ctypes.CDLL(str(toolchain.shared_library("both", files)))
    library.both.restype = ctypes.c_double
    record = ("drive.x_enc", "drive.F_m", "observer.F")
    stop = (len(v_cmd) - 1) * T_S
    with build_loop(fmus, loop, chain).prepare(
        step=T_S, stop=stop, record=record, constant_step=True
    ) as simulation:
        measured = simulation.run({}, loop.commands(v_cmd))
    given = signals(loop, v_cmd)
    columns = given["v_cmd"], given["x_cmd"], measured["drive.x_enc"], measured["drive.F_m"]
    rows = [[*map(ctypes.c_double, row)] for row in zip(*columns, strict=True)]
    library.start(*rows[0])
    force = np.array([library.both(*row) for row in rows])
    part = slice(700)  # without the loop, in which it stays, a difference of rounding grows
    assert np.ptp(force[part]) > 2.0
    np.testing.assert_allclose(force[part], measured["observer.F"][1:][part], rtol=0, atol=1e-9)
