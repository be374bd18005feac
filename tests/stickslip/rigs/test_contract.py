"""What every rig promises: the paper's loop, limits, and logs that are kept."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from stickslip import (
    Command,
    Datasheet,
    FmuRig,
    KeptRig,
    Limits,
    Log,
    Rig,
    RigLimits,
    learn,
    validate,
)
from stickslip.errors import HarmfulError, LimitError, RigError, UsageError
from stickslip.evaluation.motions import TRAINING
from stickslip.identification.stages import Estimate
from stickslip.servo.axis import LOOP
from stickslip.studies.learn.controller_findings import check_rig
from stickslip.studies.learn.recorded import read_rig
from stickslip.tuning.learning import Study, VelocityCost
from stickslip.tuning.refinement import refine

WIDE = RigLimits(travel=(-1.0, 1.0), speed=1.0, force=300.0, following_error=0.1)


FRICTION = {"F_s": 9.0, "F_c": 8.0, "v_s": 1e-3, "sigma_0": 1e5, "sigma_1": 300.0}


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
    v_cmd = TRAINING.sample(rig.samples(0.5))
    costs = []
    for one in (rig, limited):
        with one.trials(v_cmd, one.loop, compensated=compensated) as run:
            costs.append(VelocityCost(one.T_s)(run(FRICTION)))
    assert costs[0] == costs[1]


FORCE = np.array([0.0, -51.0])


@pytest.mark.parametrize(
    ("limits", "signals", "message"),
    [
        ({"travel": (-0.01, 0.005)}, {}, "position 0.01 m; expected -0.01 to 0.005 m"),
        ({"speed": 0.05}, {}, "speed 0.1 m/s; expected at most 0.05 m/s"),
        ({"force": 50.0}, {"velocity": None, "force": FORCE}, "force 51 N; expected at most 50 N"),
        ({"force": 50.0}, {"velocity": np.zeros(2), "added_force": FORCE}, "force 51 N"),
    ],
)
def test_a_command_beyond_a_limit_moves_nothing(limits, signals, message):
    rig = Ideal(replace(WIDE, **limits))
    with pytest.raises(LimitError, match=f"nothing has moved: {message}"):
        rig.run(Command(rig.T_s, rig.loop, **{"velocity": np.full(200, 0.1), **signals}))
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


class Broken(Exception):
    """An error of somebody's own rig."""


class Failing(Ideal):
    """A drive whose program fails or dies in one of its motions, while it moves."""

    def __init__(self, number, fault):
        super().__init__(WIDE)
        self.number, self.fault = number, fault

    def move(self, command):
        log = super().move(command)
        if self.moved == self.number:
            raise self.fault
        return log


@pytest.mark.parametrize("kind", [Broken, ValueError, UsageError])
def test_an_error_of_move_ends_the_learning_after_that_motion(fmus, kind):
    rig = Failing(3, kind("the fieldbus\nis down"))
    rig.fmus = fmus
    start = {name: Estimate(value, 0.1 * value) for name, value in FRICTION.items()}
    study = Study(rig, rig.loop, start, TRAINING.sample(rig.samples(0.05)))
    message = f"drive: motion 3: {kind.__name__}: the fieldbus is down; expected a log from move"
    with pytest.raises(RigError, match=message):
        refine(study)
    assert rig.moved == 3


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda log: log.table(), "move returned a DataFrame; expected ss.Log"),
        (lambda log: Log(1e3 * log.t, log.x_enc, log.F_m), "a spacing of 0.5 s; expected T_s = 0"),
        (lambda log: Log(1.02 * log.t, log.x_enc, log.F_m), "Give times in seconds"),
        (lambda log: Log(0.0 * log.t, log.x_enc, log.F_m), "does not rise at sample 1"),
    ],
)
def test_a_log_that_is_not_of_the_command_is_no_limit(change, said):
    rig = Ideal(WIDE)
    rig.move = lambda command: change(Ideal.move(rig, command))
    with pytest.raises(RigError, match=f"drive: motion 1: .*{said}") as fault:
        rig.follow(np.full(100, 0.01), rig.loop)
    assert not isinstance(fault.value, LimitError)


@pytest.mark.parametrize("T_s", [0.0, -1e-3, np.nan, np.inf])
def test_a_rig_has_a_sample_period(T_s):
    with pytest.raises(UsageError, match=f"drive.fmu: T_s = {T_s} s; expected a finite number"):
        FmuRig("fmus", Datasheet(), T_s)


@pytest.mark.parametrize(
    ("noise", "length", "is_wrong"),
    [(0.0, 1.0, False), (3.0, 1.0, False), (0.0, 1.1, True), (0.0, -1.0, True), (0.0, 1e3, True)],
)
def test_a_log_in_other_units_spoils_the_values_and_noise_does_not(fmus, noise, length, is_wrong):
    class Measured(FmuRig):
        def move(self, command):
            log = super().move(command)
            added = noise * np.random.default_rng(1).standard_normal(len(log.t))
            return Log(log.t, length * log.x_enc, log.F_m + added)

    found = list(check_rig(read_rig(Measured(fmus, Datasheet(), LOOP.T_s), Limits(duration=5.0))))
    assert [one.spoils for one in found] == ["values"] * is_wrong
    assert all("not that of the loop and the command" in one.what for one in found)


def test_a_compensator_that_is_not_recommended_moves_nothing():
    rig, learned = Ideal(WIDE), SimpleNamespace(refusal="the force is out of scale")
    with pytest.raises(HarmfulError, match="does not recommend it: the force is out of scale; not"):
        validate(rig, learned)
    assert not rig.moved


def experiment(rig, last=0.04):
    """Run three motions, each of which follows from the log before."""
    x = 0.01
    for v in (0.02, 0.03, last):
        x = rig.follow(np.full(100, v + x), rig.loop).x_enc[-1]
    return x


def test_what_was_done_is_not_done_again_and_the_interrupted_motion_only_when_asked(tmp_path):
    expected = experiment(Ideal(WIDE))
    with pytest.raises(KeyboardInterrupt):
        experiment(KeptRig(Failing(2, KeyboardInterrupt()), tmp_path))
    drive = Ideal(WIDE)
    begun = tmp_path / "motion-0002.json"
    with pytest.raises(RigError, match=r"motion-0002\.json: motion 2 of 0\.05 s was begun and has"):
        experiment(KeptRig(drive, tmp_path))
    assert not drive.moved
    begun.unlink()
    assert experiment(KeptRig(drive, tmp_path)) == expected
    assert drive.moved == 2
    assert experiment(KeptRig(drive, tmp_path)) == expected
    assert drive.moved == 2


def test_a_folder_of_another_run_is_refused(tmp_path):
    experiment(KeptRig(Ideal(WIDE), tmp_path))
    drive = Ideal(WIDE)
    with pytest.raises(RigError, match=r"motion-0003\.npz: is of another command than motion 3"):
        experiment(KeptRig(drive, tmp_path), last=0.05)
    assert not drive.moved


def test_a_limit_that_aborted_a_motion_does_so_again_without_it(tmp_path):
    for drive in (Failing(1, LimitError("speed 2 m/s")), Ideal(WIDE)):
        kept = KeptRig(drive, tmp_path)
        with pytest.raises(LimitError, match="speed 2 m/s"):
            kept.follow(np.full(100, 0.5), kept.loop)
        assert drive.moved == isinstance(drive, Failing)


def test_a_folder_of_another_rig_is_refused_and_what_is_taken_is_said(tmp_path, caplog):
    experiment(KeptRig(Ideal(WIDE), tmp_path))
    assert not caplog.messages
    experiment(KeptRig(Ideal(WIDE), tmp_path))
    said = [f"motion {k} is taken from {tmp_path}; the drive was not moved" for k in (1, 2, 3)]
    assert caplog.messages == said
    for change, named in [
        ({"name": "x-axis"}, "name drive; expected x-axis. Give another folder"),
        ({"datasheet": Datasheet(mass=9.0)}, "datasheet .*'mass': 5.5.*; expected .*'mass': 9.0"),
        ({"limits": replace(WIDE, force=200.0)}, "limits .*'force': 300.0.*; expected .*200.0"),
    ]:
        drive = Ideal(WIDE)
        vars(drive).update(change)
        with pytest.raises(RigError, match=rf"motion-0001\.npz: is of another rig: {named}"):
            experiment(KeptRig(drive, tmp_path))
        assert not drive.moved
