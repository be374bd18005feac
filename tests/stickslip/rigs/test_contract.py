"""What every rig promises: the paper's loop, and limits."""

from dataclasses import replace

import numpy as np
import pytest

from stickslip import Command, FmuRig, Limits, Log, Rig, RigLimits, learn
from stickslip.errors import LimitError, RigError, UsageError
from stickslip.pipeline.recorded import read_rig
from stickslip.servo.datasheet import LOOP, Datasheet
from stickslip.servo.paper_commands import TRAINING
from stickslip.tuning.learning import VelocityCost

WIDE = RigLimits(travel=(-1.0, 1.0), speed=1.0, force=300.0, following_error=0.1)


class Ideal(Rig):
    """A drive that follows each velocity at once, with a force of 1 N."""

    def __init__(self, limits):
        super().__init__(Datasheet(), LOOP.T_s, limits)
        self.moved = 0

    def move(self, command):
        self.moved += 1
        v = np.zeros(len(command)) if command.velocity is None else command.velocity
        x = self.T_s * np.concatenate([[0.0], np.cumsum(v[:-1])])
        return Log(np.arange(len(x)) * self.T_s, x, np.ones(len(x)))


@pytest.mark.parametrize("compensated", [True, False])
def test_a_candidate_costs_the_same_as_in_the_loop_of_fmus(fmus, compensated):
    rig, limited = (FmuRig(fmus, Datasheet(), LOOP.T_s, limits=one) for one in (None, WIDE))
    v_cmd, values = TRAINING.sample(rig.samples(0.5)), np.array([9.0, 8.0, 1e-3, 1e5, 300.0])
    costs = []
    for one in (rig, limited):
        how = {"compensated": compensated}
        with one.cost_of(v_cmd, one.loop, VelocityCost(one.T_s), **how) as cost:
            costs.append(cost(values))
    assert costs[0] == costs[1]


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"travel": (-0.01, 0.005)}, "position 0.01 m; expected -0.01 to 0.005 m"),
        ({"speed": 0.05}, "speed 0.1 m/s; expected at most 0.05 m/s"),
    ],
)
def test_a_command_beyond_a_limit_moves_nothing(limits, message):
    rig = Ideal(replace(WIDE, **limits))
    with pytest.raises(LimitError, match=f"nothing has moved: {message}"):
        rig.follow(np.full(200, 0.1), rig.loop)
    assert not rig.moved


def test_nor_does_a_force_beyond_the_limit():
    rig = Ideal(replace(WIDE, force=50.0))
    with pytest.raises(LimitError, match="nothing has moved: force 51 N; expected at most 50 N"):
        rig.push(np.array([0.0, -51.0]))
    added = Command(rig.T_s, rig.loop, velocity=np.zeros(2), added_force=np.array([0.0, 51.0]))
    with pytest.raises(LimitError, match="nothing has moved"):
        rig.run(added)
    assert not rig.moved


@pytest.mark.parametrize(
    ("limits", "push", "message"),
    [
        ({"travel": (-1e-3, 1e-3)}, True, r"position 0\.001\d+ m; expected -0.001 to 0.001 m"),
        ({"speed": 0.02}, True, r"speed 0\.02\d* m/s; expected at most 0.02 m/s"),
        ({"force": 5.0}, False, r"force \d+\.?\d* N; expected at most 5 N"),
        ({"following_error": 1e-6}, False, r"following error .* m; expected at most 1e-06 m"),
    ],
)
def test_a_limit_aborts_a_motion(fmus, limits, push, message):
    rig = FmuRig(fmus, Datasheet(), LOOP.T_s, limits=replace(WIDE, **limits))
    with pytest.raises(LimitError, match=f"the motion was aborted at .* s: {message}"):
        rig.push(np.full(400, 30.0)) if push else rig.follow(np.full(400, 0.01), rig.loop)


def test_a_candidate_that_a_limit_aborts_has_failed_and_another_fault_ends_the_learning(fmus):
    rig = Ideal(replace(WIDE, force=5.0))
    rig.fmus = fmus
    v_cmd, strong = TRAINING.sample(rig.samples(0.1)), np.array([900.0, 800.0, 1e-3, 1e5, 300.0])
    with rig.cost_of(v_cmd, rig.loop, VelocityCost(rig.T_s)) as cost:
        with pytest.raises(Exception, match="nothing has moved") as failed:
            cost(strong)
        assert type(failed.value).__name__ == "CandidateFailed"
        assert cost.fatal == (RigError,)
    assert not rig.moved


def test_learn_records_the_rig_in_its_loop_and_limits_hold_for_the_experiment():
    with pytest.raises(LimitError, match="nothing has moved: speed"):
        learn(Ideal(replace(WIDE, speed=0.03)))
    rig = Ideal(WIDE)
    reading = read_rig(rig, Limits(duration=2.0, speed=0.02))
    assert reading.controller.K_p == rig.loop.K_p
    assert len(reading.recording.t) == 4001
    moved = rig.T_s * np.cumsum(reading.recording.velocity_command[:-1])
    np.testing.assert_allclose(reading.recording.position[1:], moved, atol=1e-15)


@pytest.mark.parametrize("signals", [{}, {"velocity": [0.0], "force": [0.0]}, {"force": [np.nan]}])
def test_a_command_has_one_finite_signal(signals):
    loop = Ideal(None).loop
    with pytest.raises(UsageError, match="command"):
        Command(LOOP.T_s, loop, **{name: np.array(one) for name, one in signals.items()})
