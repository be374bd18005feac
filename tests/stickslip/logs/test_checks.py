"""Faults of a recording, what it can show, and the stretches that are learned from."""

from dataclasses import replace

import numpy as np
import pytest

from stickslip.evaluation.motions import TRAINING
from stickslip.logs import Controller, Recording, check_recording
from stickslip.logs.checked import shortened
from stickslip.logs.excitation import excitation
from stickslip.logs.joined import join
from stickslip.logs.motion import aligned
from stickslip.planning import plan
from stickslip.servo.axis import LOOP
from tests.stickslip.logs.rigid_drive import rigid_drive

DRIVE = rigid_drive(n=8000, step=4e-7)


def findings(recording, severity=None, **more) -> str:
    found = check_recording(recording, **more)
    assert all("\n" not in str(finding) for finding in found)
    return "\n".join(str(f) for f in found if severity in (None, f.severity))


@pytest.mark.parametrize(
    ("change", "found"),
    [
        ({"position": None, "velocity": None}, "neither position nor velocity"),
        ({"force": None}, "neither force nor friction"),
        ({"position": np.full(8000, 0.3)}, "position never changes: 0.3"),
        ({"force": np.zeros(8000)}, "force never changes"),
        ({"force": np.where(DRIVE.t > 2, np.nan, 1.0)}, "force holds values that are not finite"),
        ({"force": np.zeros(10)}, "10 values, expected 8000"),
    ],
)
def test_nothing_can_be_learned(change, found):
    assert found in findings(replace(DRIVE, **change), "error")


def test_a_compensator_may_be_off():
    for force, told in ((0.0, False), (3.0, True)):
        found = findings(replace(DRIVE, added_force=np.full(8000, force)))
        assert ("added_force never changes" in found) == told


def test_a_controller_without_its_command():
    found = findings(DRIVE, "error", controller=Controller("PI", K_p=1.0, K_i=1.0))
    assert "no velocity_command" in found
    known = Controller("P", P_x=1.0)
    assert not findings(DRIVE, "error", controller=known)
    silent = replace(DRIVE, force=None)
    assert not findings(silent, "error", controller=known)
    [of_gains] = [one for one in check_recording(silent, controller=known) if one.spoils]
    assert "all forces follow from the gains" in of_gains.what
    sent = replace(silent, force_command=DRIVE.force)
    assert not [one for one in check_recording(sent, controller=known) if one.spoils]


@pytest.mark.slow
def test_the_plan_shows_all_and_the_sweep_not_f_s_and_v_s(drive_log):
    planned = drive_log(plan()["velocity_command"].to_numpy())
    assert not findings(planned, "warning")
    assert "sigma_0 and sigma_1 may be identifiable" in findings(planned, "note")
    swept = drive_log(TRAINING.sample(np.arange(20_001) * LOOP.T_s))
    assert "F_s and v_s are poorly identifiable" in findings(swept, "warning")
    assert "m may be identifiable" in findings(swept, "note")


def test_reversals_are_those_of_the_command(drive_log):
    swept = drive_log(TRAINING.sample(np.arange(20_001) * LOOP.T_s))
    v = TRAINING.sample(swept.t)
    expected = np.sum(np.diff(np.sign(v[np.abs(v) > 1e-3])) != 0)
    assert abs(excitation(swept).reversals - expected) <= 1
    rest = replace(swept, position=swept.encoder_step * (np.arange(len(v)) % 7 == 0))
    assert excitation(rest).reversals == 0


def test_slow_motion_is_measured_against_the_top_speed():
    """A triangle of velocity is slower than a hundredth of its top for a hundredth of the time."""
    t = np.arange(20_000) * 1e-3
    v = 0.04 * (2 / np.pi) * np.arcsin(np.sin(2 * np.pi * t / 5))
    shown = excitation(Recording(t, np.cumsum(v) * 1e-3, v, velocity=v))
    assert shown.slow == pytest.approx(0.01, rel=0.15)
    assert shown.top_speed == pytest.approx(0.04, rel=0.01)
    assert shown.speeds == pytest.approx((0.05 * 0.04, 0.95 * 0.04), rel=0.05)


def test_a_recording_shorter_than_its_low_pass_is_checked():
    """60 samples in 60 us: everything lies near a reversal."""
    short = Recording(np.arange(60) * 1e-6, DRIVE.position[:60], force=DRIVE.force[:60])
    assert "the recording is short" in findings(short)


def test_motion_in_one_direction_hides_coulomb_friction():
    """Its force and a constant one have the same sign throughout."""
    drive = rigid_drive(n=8000, step=4e-7)
    t = drive.t
    v = 0.02 + 0.015 * np.sin(2 * np.pi * (0.4 * t + 0.1 * t**2))
    force = 3.0 * np.gradient(v, t) + 20.0 * v + 4.0
    for way in (1.0, -1.0):
        log = Recording(t, way * np.cumsum(v) * drive.T_s, way * force)
        [found] = [one for one in check_recording(log) if one.spoils]
        assert "cannot be told apart" in found.what
        assert "F_c" in found.hides
    assert not any(one.hides for one in check_recording(DRIVE))
    swung = 0.05 * np.sin(2 * np.pi * t) + np.where(t < 1, 2.0 * np.sin(np.pi * t) ** 2, 0.0)
    both_ways = Recording(t, np.cumsum(swung) * drive.T_s, 4.0 * np.sign(swung))
    assert not any("F_c" in one.hides for one in check_recording(both_ways))


N, T_s = 400_000, 1e-3


def swings(*parts):
    """Return a log of a minute of rest after each part: amplitude [m], duration [s]."""
    period, pause = 5.0, np.zeros(round(60.0 / T_s))
    places = []
    for amplitude, duration in parts:
        t = np.arange(round(duration / T_s)) * T_s
        places += [amplitude * np.sin(2.0 * np.pi * t / period), pause]
    x = np.concatenate(places)
    return Recording(np.arange(len(x)) * T_s, x, np.arange(len(x)) * 1.0, source="long.csv")


def test_a_long_log_is_cut_to_where_the_drive_moves_and_a_short_one_is_not() -> None:
    telling = rigid_drive(n=4000)
    position = np.zeros(N)
    position[250_000:254_000] = telling.position
    recording = Recording(np.arange(N) * T_s, position, np.arange(N) * 1.0, source="long.csv")
    for number in (1, 10):
        cut, (note,) = shortened(recording, number=number)
        used = np.concatenate([cut.log(one).force for one in cut.pieces]).astype(int)
        assert len(used) == len({*used}) == 100_000
        assert {*range(250_000, 254_000)} <= {*used}
        assert cut.source == "long.csv"
        assert cut.t[0] == 0.0
        assert note.figure.count(" to ") == len(cut.pieces)
        assert f"{used[0] * T_s:.4g} to" in note.figure
    assert shortened(telling) == (telling, ())


def test_a_log_whose_parts_show_different_things_is_cut_into_stretches_of_each() -> None:
    """No stretch of 100 s has both speeds of this log, which lie 200 s apart."""
    recording = swings((1.0, 100.0), (0.0, 100.0), (0.01, 100.0))

    def amplitudes(**more):
        cut, *_ = shortened(recording, **more)
        return {float(f"{np.ptp(cut.log(one).position):.1g}") for one in cut.pieces}, cut

    assert amplitudes(number=1)[0] == {2.0}
    both, cut = amplitudes()
    assert {2.0, 0.02} <= both
    _, fewer = amplitudes(share=0.2)
    assert len(fewer.segments) == 2
    assert max(one.end - one.begin for one in fewer.segments) == 10_000
    assert not cut.joins_several
    assert np.ptp(cut.first.position) == pytest.approx(2.0, rel=1e-3)  # where it moves farthest
    for one in cut.segments:
        part = cut.log(one)
        at = part.force.astype(int)
        np.testing.assert_array_equal(part.position, recording.position[at])
        if at[0] and np.ptp(part.position) > 1.0:  # it slides slowly there
            v = abs(np.gradient(part.position, T_s)[10]) / (0.4 * np.pi)
            assert v == pytest.approx(0.03, rel=0.5)
        assert one.source == "long.csv"


@pytest.mark.parametrize("late", [3, -3])
def test_the_force_of_stretches_is_aligned_in_each(late):
    cut, *_ = shortened(swings((1.0, 100.0), (0.0, 100.0), (0.01, 100.0)))
    moved = aligned(cut, late)
    assert len(moved.segments) == len(cut.segments)
    for one, own in zip(moved.segments, cut.segments, strict=True):
        x, of = moved.log(one), cut.log(own)
        begin = max(-late, 0)
        np.testing.assert_array_equal(x.position, of.position[begin : begin + len(x.t)])
        np.testing.assert_array_equal(x.force - x.force[0], np.arange(len(x.t)))
        assert x.force[0] - of.force[0] == max(late, 0)


def test_a_log_of_stretches_is_joined_with_others() -> None:
    cut, *_ = shortened(swings((1.0, 100.0), (0.0, 100.0), (0.01, 100.0)))
    other = replace(swings((1.0, 5.0)), source="other.csv")
    both = join([other, cut], [{"K_p": 1.0}, {"K_p": 2.0}], [0.0, 3.0])
    assert both.joins_several
    assert both.source == "other.csv and long.csv"
    assert join([cut, cut], [None, None], [0.0, 0.0]).joins_several  # two of the same name
    assert len(both.first.t) == len(other.t)
    first, *rest = both.segments
    assert (first.gains, first.load) == ({"K_p": 1.0}, 0.0)
    assert {(one.gains["K_p"], one.load) for one in rest} == {(2.0, 3.0)}
    for one, own in zip(rest, cut.segments, strict=True):
        np.testing.assert_array_equal(both.log(one).force, cut.log(own).force)
    quick = replace(cut, t=0.5 * cut.t)
    at_rate = join([other, quick], [None, None], [0.0, 0.0])
    for one, own in zip(at_rate.segments[1:], cut.segments, strict=True):
        slow, fast = at_rate.log(one).position, cut.log(own).position
        assert len(slow) == pytest.approx(len(fast) / 2, abs=1)
        assert slow[0] in fast[:2]
        np.testing.assert_array_equal(slow, fast[list(fast).index(slow[0]) :: 2][: len(slow)])
