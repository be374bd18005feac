"""Any compensators in the paper's loop, connected by the roles of their ports."""

import numpy as np
import pytest

from stickslip import cosim, models
from stickslip.catalog.parameters import PAPER
from stickslip.servo.axis import Axis
from stickslip.servo.systems import BLOCKS, Compensator, build_loop
from stickslip.servo.velocity_loop import LoopSpecification, design_velocity_loop

SINE = cosim.SineSweep(frequency=(1.0, 1.0), amplitude=(0.01, 0.01), duration=1.0)


@pytest.fixture(scope="module")
def loop():
    return design_velocity_loop(Axis(PAPER["m"], PAPER["b"]), LoopSpecification(60.0, 60.0))


def run(system, **parameters):
    with system.prepare(step=5e-4, stop=1.0) as simulation:
        return simulation.run(parameters=parameters, inputs={"v_cmd": SINE})


def error(result) -> float:
    return float(np.sqrt(np.mean((result["drive.v"] - result["nominal.v_r"]) ** 2)))


@pytest.mark.parametrize(
    ("models_", "share"),
    [
        (["static_feedforward"], 0.6), (["dob"], 0.8), (["coulomb_observer"], 0.6),
        (["momentum_observer"], 0.8), (["lugre_observer"], 0.4), (["lffc"], 0.9), (["rbf"], 0.95),
        (["mlp"], 0.95), (["lugre_network"], 0.4), (["static_feedforward", "dob"], 0.6),
    ],
)  # fmt: skip
def test_compensators_chain_and_reduce_the_error(fmus, loop, models_, share):
    """The chain's force is the sum of its parts, and the drive follows better than without."""
    without = error(run(build_loop(fmus, loop, [])))
    chain = [Compensator(name, name) for name in models_]
    result = run(build_loop(fmus, loop, chain))
    assert error(result) < share * without
    if len(models_) == 2:
        before = np.append(0.0, result["static_feedforward.F"][1:])  # dob steps after it
        np.testing.assert_array_equal(result["dob.F"], before - result["dob.d_hat"])


@pytest.mark.parametrize(
    ("model", "nothing"),
    [
        *((name, {"share": 0.0}) for name in ("dob", "coulomb_observer", "momentum_observer")),
        ("static_feedforward", {"F_c": 0.0}),
        *((name, {"gamma": 0.0}) for name in ("lffc", "rbf", "mlp")),
    ],
)
def test_a_compensator_that_adds_nothing_leaves_the_loop_as_it_is(fmus, loop, model, nothing):
    """Bit for bit; in a chain an observer passes the force before it on one sample late."""
    without = run(build_loop(fmus, loop, []))
    beside = run(build_loop(fmus, loop, [Compensator("beside", model, nothing)]))
    for name in without.names:
        assert without[name].tobytes() == beside[name].tobytes()


@pytest.mark.parametrize("model", ["dob", "coulomb_observer", "momentum_observer"])
def test_an_observer_takes_back_what_a_feedforward_gives_too_much(fmus, loop, model):
    """Friction is half of what the feedforward knows: a negative amplitude corrects it."""
    half = {f"drive.{name}": 0.5 * PAPER[name] for name in ("F_c", "F_s")}
    chain = [Compensator("static", "static_feedforward"), Compensator("observer", model)]
    alone, both = (error(run(build_loop(fmus, loop, chain[:n]), **half)) for n in (1, 2))
    assert both < 0.7 * alone


def test_a_correction_reduces_what_wrong_bristles_leave(fmus, loop):
    """A LuGre observer whose friction is 20 % low, where the encoder does not disturb it."""
    low = {"F_c": 0.8 * PAPER["F_c"], "F_s": 0.8 * PAPER["F_s"]}
    exact = {"drive.encoder": False, "drive.dac": False}

    def left(k_e: float) -> float:
        observer = Compensator("o", "lugre_observer", {**low, "k_e": k_e})
        return error(run(build_loop(fmus, loop, [observer]), **exact))

    assert left(1.0) < 0.95 * left(0.5) < 0.95 * 0.98 * left(0.0)


def test_a_compensator_that_cannot_pass_a_force_on_comes_first(fmus, loop):
    chain = [Compensator("first", "dob"), Compensator("second", "compensator")]
    with pytest.raises(ValueError, match=r"'second' cannot add its force to first\.F; put"):
        build_loop(fmus, loop, chain)
    with pytest.raises(ValueError, match="'stage' is not a compensator"):
        build_loop(fmus, loop, [Compensator("stage", "stage")])


def test_every_compensator_has_ports_and_tunes_its_own_parameters():
    folders = {name: models.load_model(name) for name in models.model_names()}
    exported_only = {*BLOCKS.values(), "position_force"}
    assert exported_only <= folders.keys()
    for name, model in folders.items():
        is_compensator = model.folder.parent.name == "compensators"
        assert (model.ports is not None) == (is_compensator and name not in exported_only), name
        if model.ports is not None:
            own = {v.name.partition("[")[0] for v in model.variables if v.role == "parameter"}
            assert {*model.ports.tuned, *model.ports.axis} <= own
            inputs = {v.name for v in model.variables if v.role == "input"}
            assert {*model.ports.inputs} == inputs
            assert model.ports.output in {v.name for v in model.variables if v.is_output}
