"""Logs of position loops: what of them is read, kept, and learned."""

import json
from dataclasses import replace
from unittest.mock import patch

import numpy as np
import pandas as pd
import pytest

from stickslip import models
from stickslip.catalog.parameters import unit_of
from stickslip.cli import main
from stickslip.errors import UsageError
from stickslip.identification.estimation import LearnSettings
from stickslip.learned.file import LearnedFile
from stickslip.learned.writing import loop_document
from stickslip.logs import Description, Recording, read_and_check
from stickslip.logs.description import Controller
from stickslip.logs.reading import read_recording, with_velocity_command
from stickslip.loops.drive_loop import DriveLoop
from stickslip.loops.family_cost import FamilyCost
from stickslip.loops.other_gains import try_other_gains
from stickslip.planning import LINEAR, plan
from stickslip.servo.axis import Axis
from stickslip.servo.systems import Compensator, build_fmus, build_loop
from stickslip.servo.velocity_loop import (
    LoopSpecification,
    close_velocity_loop,
    design_velocity_loop,
)
from stickslip.studies.learn.folder import write_learned
from stickslip.studies.learn.learned import LearnedFromRecording
from stickslip.studies.learn.log_learning import learn, with_other_gains, with_tracking
from stickslip.studies.learn.verdict import verdict_of
from stickslip.studies.tune.run import masses_of
from stickslip.studies.validate.log_validation import read_log
from stickslip.trial.family import Drive, commands

T_S = 5e-4
GAINS = {"K_x": 40.0, "K_p": 500.0, "K_i": 8e3}


def recording(**signals):
    t = T_S * np.arange(2000)
    x_cmd = 1e-3 * np.sin(20.0 * t)
    return Recording(t, x_cmd, force=np.cos(20.0 * t), position_command=x_cmd, **signals)


@pytest.mark.parametrize(
    ("given", "logged", "share", "derived"),
    [
        (None, False, 0.0, False),
        (None, True, 1.0, False),
        (0.0, True, 0.0, False),
        (0.0, False, 0.0, False),
        (0.7, False, 0.7, True),
        (0.7, True, 0.7, False),
    ],
)
def test_the_velocity_that_a_cascade_follows(given, logged, share, derived):
    log = recording(velocity_command=np.ones(2000)) if logged else recording()
    controller = Controller("P-PI", **GAINS, velocity_feedforward=given)
    found, resolved = with_velocity_command(log, controller)
    assert resolved.parameters()["velocity_feedforward"] == share
    if derived:
        expected = 20.0 * 1e-3 * np.cos(20.0 * log.t)
        assert found.velocity_command[5:-5] == pytest.approx(expected[5:-5], abs=1e-9)
    else:
        assert found is log


def test_percent_of_feedforward_are_refused_in_a_line(tmp_path):
    log = recording()
    path = tmp_path / "log.csv"
    columns = {"time [s]": log.t, "position [m]": log.position, "force [N]": log.force}
    pd.DataFrame(columns | {"position_command [m]": log.position}).to_csv(path, index=False)
    given = Description(controller="P-PI", gains={**GAINS, "velocity_feedforward": 100.0})
    with pytest.raises(UsageError, match=r"velocity_feedforward = 100: expected 0 to 2; 100 % are"):
        read_recording(path, given)
    with pytest.raises(UsageError, match=r"P-PI: expected gains K_i and K_p and K_x .and velocity"):
        Description(controller="P-PI", gains={"K_x": 1.0, "K_p": 1.0})


def of(axis, share, K_x, bandwidth):
    """Return a cascade of usual margins."""
    inner = design_velocity_loop(axis, LoopSpecification(bandwidth, 50.0, T_S, T_S))
    return close_velocity_loop(
        axis, T_S, T_S, inner.K_p, inner.K_i, K_x=K_x, velocity_feedforward=share
    )


def test_learned_json_keeps_the_loop_and_another_log_runs_in_it(tmp_path):
    loop = of(Axis(1.0, 2.0, 1e-4), 0.3, 40.0, 80.0)
    names = ("F_s", "F_c", "v_s", "sigma_0", "sigma_1")
    parameters = {name: {"value": 1.0, "unit": unit_of(name)} for name in (*names, "m", "b")}
    path, log = tmp_path / "learned.json", recording()
    path.write_text(json.dumps({"parameters": parameters, "loop": loop_document(loop)}))
    file = LearnedFile(path)
    columns = {"time [s]": log.t, "position [m]": log.position, "force [N]": log.force}
    columns["position_command [m]"] = log.position
    pd.DataFrame(columns).to_csv(tmp_path / "log.csv", index=False)
    taken = read_log(tmp_path / "log.csv", Description(), file)
    assert taken.controller == "the cascade controller of learned.json"
    assert {n: taken.gains[n] for n in ("K_x", "K_p")} == {"K_x": 40.0, "K_p": loop.K_p}
    assert taken.gains["velocity_feedforward"] == 0.3
    assert taken.reading.recording.velocity_command is not None
    path.write_text(json.dumps({"parameters": parameters}))
    assert read_log(tmp_path / "log.csv", Description(), LearnedFile(path)).gains is None


TRUTH = {"m": 1.0, "b": 2.0, "F_c": 2.0, "F_s": 3.0, "sigma_1": 500.0}


def moved(fmus, loop, v_cmd, chain=(), **inputs):
    system = build_loop(fmus, loop, chain, connected=bool(chain))
    stop = (len(v_cmd) - 1) * T_S
    record = ("drive.x", "drive.x_enc", "drive.F_m")
    with system.prepare(step=T_S, stop=stop, record=record) as simulation:
        return simulation.run({}, loop.commands(v_cmd) | inputs)


@pytest.mark.thorough
@pytest.mark.slow
@pytest.mark.usefixtures("brief")
def test_a_log_of_a_cascade_gives_the_drive_and_less_position_error(tmp_path, capsys):
    """Without velocity feedforward, which the log of a position command alone stands for."""
    start = {one.name: one.start for one in models.load_model("drive").variables}
    build_fmus(tmp_path, {**TRUTH, "dac": False})
    loop = of(Axis(TRUTH["m"], TRUTH["b"], start["tau_i"]), 0.0, 40.0, 80.0)
    table = plan(replace(LINEAR, duration=8.0, rate=1.0 / T_S))
    v_cmd, x_cmd = (table[key].to_numpy() for key in ("velocity_command", "position_command"))
    shown = moved(tmp_path, loop, v_cmd, x_cmd=x_cmd)
    log = {"time [s]": table["time"], "position [m]": shown["drive.x_enc"]}
    log |= {"force [N]": shown["drive.F_m"], "position_command [m]": x_cmd}
    pd.DataFrame(log).to_csv(tmp_path / "log.csv", index=False)
    gains = {key: getattr(loop, key) for key in ("K_x", "K_p", "K_i", "tau_f")}
    given = Description(controller="P-PI", gains=gains, tau_i=start["tau_i"])
    learned = learn(tmp_path / "log.csv", given, law="lugre", compensator="lugre")
    assert learned.estimation.criterion == "output error"
    known = learned.estimation.known
    for key in ("m", "b", "F_c"):
        assert known[key].low <= TRUTH[key] <= known[key].high, known[key]
    assert abs(learned.estimation.parameters["F_0"]) < 0.02 * TRUTH["F_c"]
    found = learned.designed.compensated
    assert learned.designed.known
    assert (found.K_x, found.velocity_feedforward) == (40.0, 0.0)
    assert {row.figure for row in learned.trial.benefit.rows} == {"velocity", "position"}
    assert set(learned.trial.holds) == {"none", learned.trial.compared.chosen.name}
    assert not learned.refusal
    slow = {**learned.estimation.gains, "K_x": 15.0}  # with which the drive lags more than the log
    lagging = replace(learned, estimation=replace(learned.estimation, gains=slow))
    doubted = with_tracking(read_and_check(tmp_path / "log.csv", given)[0], lagging)
    assert "expected the same within a factor of 1.25" in doubted.refusal
    assert not doubted.writes()
    assert "is not that of the log" in verdict_of(doubted).headline
    words = ["learn", str(tmp_path / "log.csv"), "--check", "--controller", "P-PI", "--gain"]
    for K_x, expected in ((15.0, 1), (gains["K_x"], 0)):
        assert main([*words, *(f"{n}={x}" for n, x in {**gains, "K_x": K_x}.items())]) == 0
        assert capsys.readouterr().out.count("does not command the logged force") == expected
    told = learned.other_gains
    fixed = with_other_gains(replace(learned, other_gains=None), LearnSettings(fixed_gains=True))
    assert fixed.other_gains is None
    dahl = {
        "sigma_0": 3e6,
        "F_c": learned.friction["F_c"],
    }  # feedforward of a law that also explains
    other = replace(learned.trial, drives=(*learned.trial.drives, Drive("it", "dahl", dahl)))
    rival = Compensator("compensator", "compensator", dahl, law="dahl")
    assert learned.choice == "feedforward"
    with patch.object(LearnedFromRecording, "feedforward", rival):
        assert with_other_gains(replace(learned, trial=other), LearnSettings()).other_gains
    write_learned(learned, tmp_path / "learned")
    file = LearnedFile(tmp_path / "learned" / "learned.json")
    assert file.document["other_gains"]["error"] == {"value": told.error, "unit": "1"}
    assert told.sentence[1:] in (tmp_path / "learned" / "report.html").read_text("utf-8")
    start = DriveLoop.of(file)  # tuning begins where other gains were tried
    with file.bench(start.loop) as one, FamilyCost(one, start, masses_of(file), ()) as cost:
        assert try_other_gains(cost) == told
    # On the true drive, on other commands; its position against that without friction.
    chain = [Compensator("compensator", "compensator", learned.compensator)]
    for command in commands(learned.trial.command, T_S, learned.friction, 4e-7):
        _, target = loop.response(command.v_cmd)
        without, compensated = (
            np.sqrt(np.mean((moved(tmp_path, loop, command.v_cmd, parts)["drive.x"] - target) ** 2))
            for parts in ((), chain)
        )
        assert compensated < 0.8 * without
