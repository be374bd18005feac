"""Runs in lanes against runs of the FMUs, bit for bit."""

import re

import numpy as np
import pytest

from stickslip import cosim, models
from stickslip.catalog.parameters import PAPER, friction_law, scaled_start
from stickslip.models.lanes.library import LEVELS
from stickslip.models.lanes.translation import translated
from stickslip.servo import lanes
from stickslip.servo.axis import Axis
from stickslip.servo.lanes import LANES, Lanes, NoLanes, Run
from stickslip.servo.systems import Compensator, build_loop, lone_chain
from stickslip.servo.velocity_loop import LoopSpecification, design_velocity_loop
from tests.kept import further

pytestmark = pytest.mark.slow

LAWS = models.law_names()
QUICK = [law for law in LAWS if law != "leuven"]
COMPENSATORS = [
    name
    for name in models.model_names()
    if models.load_model(name).ports and models.load_model(name).law is None
]
LEARNING = ("lffc", "lugre_network", "mlp", "rbf")  # an algebraic loop with the controller
T_S, N = 5e-4, 900
EXTRAS = {
    "asymmetric": True, "asymmetry": 0.2, "position_dependent": True, "ripple": True,
    "drift": 0.1, "noise": True, "dac": False, "load": 20.0, "current_loop": False,
}  # fmt: skip


@pytest.fixture(scope="module")
def loop():
    axis = Axis(PAPER["m"], PAPER["b"], 1e-4)
    return design_velocity_loop(axis, LoopSpecification(60.0, 60.0)).changed(K_x=30.0, m_ff=4.0)


def specification(folder, loop, law, chain):
    for name in ("nominal_loop", "velocity_controller"):
        models.build_fmu(name, folder)
    models.build_fmu("drive", folder, law=law, start={"seed": 3.0})
    for one in chain:
        has_law = models.load_model(one.model).law is not None
        models.build_fmu(one.model, folder, law=law if has_law else None)
    record = ("drive.x", "drive.v", "drive.F_m", "drive.x_enc", "controller.u")
    return cosim.Specification(build_loop(folder, loop, chain), T_S, N * T_S, record=record)


def runs(loop, law, seed):
    """Return runs of random drives, controllers and commands of several lengths.

    One drive has a mass that no FMU takes, one a controller that diverges.
    """
    rng, found = np.random.default_rng(seed), []
    deflection = PAPER["F_c"] / PAPER["sigma_0"]
    start = {
        name: PAPER.get(name, scaled_start(one, PAPER["F_c"], deflection))
        for name, one in friction_law(law).parameters.items()
        if len(one.start) == 1
    }
    for k in range(LANES):
        own = {f"drive.{n}": x * np.exp(0.2 * rng.standard_normal()) for n, x in start.items()}
        if "drive.F_s" in own:
            own["drive.F_s"] = max(own["drive.F_s"], own["drive.F_c"])
        extras = [name for name in EXTRAS if rng.random() < 0.4]
        own |= {f"drive.{name}": EXTRAS[name] for name in extras}
        own["controller.K_p"] = loop.K_p * np.exp(0.3 * rng.standard_normal())
        if k == 2:
            own["drive.m"] = -1.0
        if k == 5:
            own["controller.K_p"] = 1e300
        t = np.arange(N + 1) * T_S
        v_cmd = 0.02 * rng.random() * np.sin(2.0 * np.pi * rng.uniform(1.0, 8.0) * t)
        found.append(Run(own, loop.commands(v_cmd), (N - 100 * k) * T_S))
    return found


LARGE = ("armstrong", "elasto_plastic", "leuven")  # which take longest to compile
CASES = [
    *((law, ["compensator", "dob"]) for law in LAWS if law not in LARGE),
    *further(*((law, ["compensator", "dob"]) for law in LARGE)),
    *(
        (QUICK[k % len(QUICK)], [name])
        for k, name in enumerate(COMPENSATORS)
        if name not in LEARNING
    ),
]


@pytest.mark.parametrize(("law", "chain"), CASES)
def test_lanes_have_the_bits_of_the_fmus(tmp_path, loop, law, chain):
    """Beside a lane that is refused and one that fails; with LuGre for each kind of processor."""
    whole = specification(tmp_path, loop, law, [Compensator(name, name) for name in chain])
    levels = range(LEVELS) if law == "lugre" else [None]
    compare(whole, runs(loop, law, seed=len(law) + len(chain[0])), [2, 5], levels)


@pytest.mark.parametrize("model", LEARNING)
def test_compensators_that_learn_have_the_bits_of_the_fmus_without_a_loop(tmp_path, loop, model):
    models.build_fmu(model, tmp_path)
    system, force = lone_chain(tmp_path, loop, [Compensator(model, model)])
    whole = cosim.Specification(system, T_S, N * T_S, record=(force,))
    rng, tried = np.random.default_rng(1), []
    sizes = {"v_ref": 0.02, "u": 80.0}
    t = np.arange(N + 1) * T_S
    for k in range(LANES):
        wave = np.sin(2.0 * np.pi * rng.uniform(1.0, 8.0) * t)
        inputs = {role: sizes[role] * rng.random() * wave for role in system.inputs}
        own = {f"{model}.gamma": 0.1 * rng.random(), f"{model}.m": PAPER["m"] * (1.0 + 0.1 * k)}
        tried.append(Run(own, inputs, (N - 50 * k) * T_S))
    compare(whole, tried, fail=[], levels=[None])


def compare(whole, tried, fail, levels):
    """Compare runs in lanes with those of the FMUs, of which some fail."""
    with whole.prepare() as simulation:
        expected = []
        for one in tried:
            try:
                expected.append(simulation.run(*one[:2], until=one.until))
            except cosim.CosimError:
                expected.append(None)
    assert [k for k, one in enumerate(expected) if one is None] == fail
    for level in levels:
        found = Lanes(whole, level).run(tried)
        for one, other in zip(found, expected, strict=True):
            assert (one is None) == (other is None)
            if one is not None:
                assert one.names == other.names
                np.testing.assert_array_equal(one.time, other.time)
                np.testing.assert_array_equal(one.values, other.values)


def test_what_lanes_do_not_run_is_left_to_the_fmus(tmp_path, loop, monkeypatch, caplog):
    whole = specification(tmp_path, loop, "lugre", [])
    odd = Run({"drive.nothing": 1.0}, {}, None)
    short = Run({}, {"v_cmd": np.zeros(3)}, None)
    wrong = Run({"drive.noise": 0.5}, {}, None)
    assert Lanes(whole).run([odd, short, wrong, odd]) == [None] * 4
    with pytest.raises(NoLanes, match="coupled"):
        Lanes(cosim.Specification(whole.system, T_S, T_S, coupling="jacobi"))
    monkeypatch.setattr(lanes, "_model_of", lambda _: None)
    caplog.set_level("INFO")
    assert lanes.lanes_of(whole) is None
    assert "one by one: nominal is not of our models" in caplog.text


def test_no_lane_computes_with_what_the_memory_held():
    """It may be denormal, with which a processor is slow."""
    for law in LAWS:
        code = translated(models.load_model("drive", law))
        assert not re.findall(r"^\s*[VMIU] \w+(?:\[\w+\])*;", code, re.MULTILINE)
