"""Plans of experiments: they keep the limits and show on the drive what they promise."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from stickslip.cli import main
from stickslip.errors import UsageError
from stickslip.planning import LINEAR, ROTARY, Limits, arrange, plan
from stickslip.planning.experiment import SHOWN


def check_limits(limits: Limits, show=()) -> None:
    table = plan(limits, show)
    time, v, x = (table[name].to_numpy() for name in table.columns)
    assert len(table) == round(limits.duration * limits.rate) + 1
    assert time[-1] == pytest.approx(limits.duration, abs=1 / limits.rate)
    assert v[0] == v[-1] == x[0] == 0
    assert abs(x[-1]) < 1e-9 * np.ptp(x)
    assert np.abs(v).max() <= limits.speed * (1 + 1e-9)
    assert np.abs(np.diff(v)).max() * limits.rate <= limits.acceleration * (1 + 1e-9)
    assert np.ptp(x) <= limits.stroke
    assert limits.travel[0] - 1e-12 <= x.min() <= x.max() <= limits.travel[1] + 1e-12
    jerk = np.abs(np.diff(v, 2, prepend=[0.0], append=[0.0])).max() * limits.rate**2
    assert jerk <= limits.jerk * (1 + 1e-6)
    np.testing.assert_allclose(np.diff(x) * limits.rate, (v[1:] + v[:-1]) / 2, atol=1e-9)
    assert np.abs(v).max() > 0


ONES = dict.fromkeys(("stroke", "speed", "acceleration"), 1.0)


@given(
    stroke=st.floats(1e-3, 10),
    speed=st.floats(1e-3, 10),
    acceleration=st.floats(1e-2, 100),
    duration=st.floats(2, 30),
    rate=st.sampled_from([100.0, 333.3, 1000.0]),
    show=st.lists(st.sampled_from(sorted(SHOWN)), max_size=3),
    jerk=st.one_of(st.just(np.inf), st.floats(0.1, 1e4)),
    share=st.one_of(st.none(), st.floats(0, 1)),
)
# four samples for each of the small moves
@example(**ONES, duration=2.0, rate=100.0, show=["F_c", "F_s"], jerk=np.inf, share=None)
# a run over the whole travel within one sample
@example(
    stroke=1e-3,
    speed=1.0,
    acceleration=62.0,
    duration=4.0,
    rate=100.0,
    show=["position_force"],
    jerk=np.inf,
    share=0.0,
)
@settings(max_examples=60)
def test_limits_are_kept(stroke, speed, acceleration, duration, rate, show, jerk, share):
    """The travel, if given, is less than the stroke, around a start at a share of it."""
    room = 0.7 * stroke
    travel = (-np.inf, np.inf) if share is None else (-share * room, (1 - share) * room)
    limits = Limits(stroke, speed, acceleration, duration, rate, jerk=jerk, travel=travel)
    try:
        check_limits(limits, show)
    except UsageError as error:
        assert "takes too long" in str(error)  # noqa: PT017 - of some examples
        assert share is not None


@pytest.mark.parametrize("limits", [LINEAR, ROTARY])
def test_the_standard_plans_use_the_speed_they_may(limits):
    check_limits(limits)
    assert plan(limits)["velocity_command"].abs().max() > 0.99 * limits.speed


@pytest.mark.parametrize(
    ("parameter", "part"), [("sigma_0", "small moves"), ("F_s", "creep"), ("m", "quick ramps")]
)
def test_what_is_asked_for_gets_more_time(parameter, part):
    def share(show):
        lasts = {s.part.name: s.end - s.begin for s in arrange(LINEAR, show)}
        return lasts[part] / sum(lasts.values())

    assert share([parameter]) > 1.4 * share([])


def test_an_arm_crosses_its_whole_travel_where_that_is_asked_for():
    limits = Limits(stroke=3.0, speed=0.8, acceleration=20.0, rate=500.0, travel=(-0.7, 0.7))
    whole, plain = (plan(limits, show)["position_command"] for show in (["position_force"], []))
    assert np.ptp(plain) < 0.9 * np.ptp(whole)
    assert np.ptp(whole) > 0.94 * 1.4


@pytest.mark.parametrize(
    "wrong",
    [
        {"jerk": 0.0}, {"travel": (0.1, 0.2)}, {"stroke": 0.0}, {"speed": float("nan")},
        {"duration": 1.0}, {"rate": 1e9}, {"presliding": (2, 1)},
    ],
    ids=str,
)  # fmt: skip
def test_invalid_limits_are_refused(wrong):
    with pytest.raises(UsageError, match=next(iter(wrong))):
        Limits(**wrong)


def test_the_command_writes_what_simulate_takes(tmp_path, capsys):
    out, plot = tmp_path / "plan.csv", tmp_path / "plan.png"
    arguments = ["plan", "--motion", "rotary", "--speed", "3", "--duration", "5", "--rate", "500"]
    assert main([*arguments, "--out", str(out), "--plot", str(plot)]) == 0
    out_text = capsys.readouterr().out
    assert "small moves" in out_text
    assert "rad below the start" in out_text
    assert plot.read_bytes().startswith(b"\x89PNG")
    table = pd.read_csv(out)
    assert list(table.columns) == ["time", "velocity_command", "position_command"]
    assert len(table) == 2501
    assert 2.9 < table["velocity_command"].abs().max() <= 3.0


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (["--out", "plan.xlsx"], ".csv"),
        (["--stroke", "100 parsec"], "--stroke = 100 parsec: expected a number, with a unit such"),
        (["--stroke", "9deg", "--speed", "3mm/s"], "--speed is in mm/s, but the motion is rotary"),
        (["--stroke", "9mm", "--motion", "rotary"], "--stroke is in mm"),
        (["--travel", "1", "2", "3"], "one or two values, got 3"),
        (["--gain", "K_p=soft"], "--gain K_p: expected a positive number"),
        (["--encoder", "-1um"], "encoder = "),
        (["--plot", "file.png"], "file.png exists; --force overwrites it"),
        (["--out", "file/plan.csv"], "file"),
    ],
)
def test_an_invalid_plan_is_reported_in_one_line(wrong, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").touch()
    (tmp_path / "file.png").touch()
    assert main(["plan", *wrong]) == 1
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert message in lines[0]


def test_what_will_not_show_is_said_beforehand(capsys, tmp_path):
    """Each gain and the encoder's step tell a speed; the largest of them is printed."""

    def least(*known):
        planned(tmp_path, *known)
        text = capsys.readouterr().out
        return float(text.partition("v_s below ")[2].split()[0]), text

    creeps, text = least("--friction", "6")
    assert "creeps no slower" in text
    assert "sigma_0 and sigma_1:" not in text
    stiff, text = least("--friction", "6", "--gain", "K_p=1e4", "K_i=1e6")
    assert stiff == pytest.approx(creeps, rel=0.1)
    soft, text = least("--friction", "6", "--gain", "K_p=1000", "K_i=1e6")
    assert soft > creeps
    assert "a higher K_p helps" in text
    assert least("--friction", "6", "--gain", "K_i=1e3")[0] > soft
    assert "a higher K_i helps" in least("--friction", "6", "--gain", "K_i=1e3")[1]
    coarse, text = least("--encoder", "0.1mm")
    assert coarse > creeps
    assert "breaks away within 0.001 m" in text


def planned(folder, *arguments):
    out = folder / "plan.csv"
    assert main(["plan", *arguments, "--rate", "500", "--out", str(out), "--force"]) == 0
    return pd.read_csv(out)


def test_limits_in_units_are_those_in_si(tmp_path, capsys):
    travel, jerk = ("--travel", "20mm", "8cm"), ("--jerk", "50m/s^3")
    limited = ("--stroke", "100mm", "--speed", "40mm/s", "--acceleration", "200cm/s2")
    table = planned(tmp_path, *limited, *jerk, *travel, "--duration", "0.25min")
    limits = Limits(0.1, 0.04, 2.0, 15.0, 500.0, jerk=50.0, travel=(-0.02, 0.08))
    pd.testing.assert_frame_equal(table, plan(limits), rtol=1e-9)
    assert "mm below the start" in capsys.readouterr().out
    table = planned(tmp_path, "--stroke", "0.25rev", "--speed", "60 rpm")
    limits = replace(ROTARY, stroke=np.pi / 2, speed=2 * np.pi, rate=500.0)
    pd.testing.assert_frame_equal(table, plan(limits), rtol=1e-9)
    assert "rev below the start" in capsys.readouterr().out


def test_a_speed_that_is_not_reached_is_a_warning(tmp_path, capsys):
    table = planned(tmp_path, "--stroke", "100mm", "--speed", "2m/s")
    error = capsys.readouterr().err
    reached = 1e3 * table["velocity_command"].abs().max()
    assert (
        f"2000 mm/s is not reached within a stroke of 100 mm, 2000 mm/s^2: {reached:.4g}" in error
    )
    planned(tmp_path, "--stroke", "100mm", "--speed", "40mm/s")
    assert not capsys.readouterr().err
