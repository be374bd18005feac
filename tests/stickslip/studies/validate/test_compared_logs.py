"""A log with the compensator against one without, of a drive that shares nothing with ours."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import cumulative_trapezoid

from campaigns.sound_drives import simulator
from stickslip.cli import main
from stickslip.errors import UsageError
from stickslip.evaluation.tracking import FEEDFORWARD, NONE
from stickslip.learned.file import LearnedFile
from stickslip.logs import Column, Description, Recording
from stickslip.logs.same_command import Overlap, period, same_command
from stickslip.studies.validate.compared_logs import common, compare, sentences
from stickslip.studies.validate.log_validation import compare_logs, read_log

T_S = 1e-3
STEP, GAINS = 5e-4, {"K_p": 1681.0, "K_i": 137167.0}  # of the drive that was logged


def sweep(n, rate=3.0):
    t = np.arange(n) * T_S
    return 0.02 * np.sin(rate * t * (1.0 + 0.3 * t))


def test_the_same_command_is_found_where_it_begins_later():
    command = sweep(4000)
    first = np.concatenate([np.zeros(700), command, np.zeros(300)])
    second = np.concatenate([np.zeros(153), command])
    (found,) = same_command(first, second, T_S)
    assert found.first - found.second == 547
    assert found.n == 4153


def test_a_command_at_another_speed_or_rate_is_another():
    command = sweep(4000)
    assert not same_command(command, 0.9 * command, T_S)
    assert sum(run.n for run in same_command(command, sweep(4000, 3.6), T_S)) < 800
    assert not same_command(command, np.zeros(4000), T_S)


def test_the_period_is_that_of_the_command():
    assert period(np.tile(sweep(1500, 9.0), 3)[:4000], T_S) == 1500
    assert period(sweep(4000), T_S) is None


def logged(command, error, position_noise=0.0):
    t = np.arange(len(command)) * T_S
    rng = np.random.default_rng(0)
    travel = cumulative_trapezoid(command, dx=T_S, initial=0)
    position = travel + error + position_noise * rng.normal(size=len(t))
    return Recording(t, position, velocity_command=command, source="log.csv")


def test_the_reduction_is_that_of_the_errors_with_an_interval_over_repetitions():
    """Errors are noise of the position; with the compensator it is 0.3 times as large."""
    command = np.tile(sweep(1500, 9.0), 12)
    without, compensated = logged(command, 0.0, 1e-5), logged(command[:15_000], 0.0, 3e-6)
    other, stretches = common(without, compensated)
    found = compare(without, other, stretches)
    assert found.repeated
    for key in ("velocity_rms", "position_rms"):
        one = found.measured.reductions[key]
        assert one.low < 0.7 < one.high
        assert one.high - one.low < 0.1
    errors = found.measured.errors
    assert errors[NONE].position_rms == pytest.approx(1e-5, rel=0.05)
    assert errors[FEEDFORWARD].position_rms == pytest.approx(3e-6, rel=0.05)


def test_other_sampling_is_brought_to_that_of_the_log_without():
    command = sweep(8000)
    error = 1e-5 * np.sin(np.arange(8000) * 0.01)
    fine, coarse = logged(command, error), logged(command, 0.5 * error)
    coarse = Recording(
        coarse.t[::4], coarse.position[::4], velocity_command=command[::4], source="coarse.csv"
    )
    other, stretches = common(fine, coarse)
    assert other.T_s == pytest.approx(T_S)
    found = compare(fine, other, stretches)
    assert found.measured.reductions["position_rms"].value == pytest.approx(0.5, abs=0.02)


def friction(velocity, F_s, F_c, v_s, sigma_0, sigma_1):
    """Return the mean friction (n,) over each step of velocities (n,) that are held."""
    z, found = 0.0, []
    for v in velocity.tolist():
        rate = sigma_0 * abs(v) / (F_c + (F_s - F_c) * math.exp(-abs(v) / v_s))
        dz = (v / rate - z) * -math.expm1(-rate * STEP) if rate else 0.0
        z += dz
        found.append(sigma_0 * z + sigma_1 * dz / STEP)
    return np.array(found)


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    """Logs of one drive; the compensated one began later and ended earlier."""
    folder = tmp_path_factory.mktemp("compared")
    n, shift = round(8.5 / STEP) + 1, round(0.837 / STEP)
    moves = 0.02 * np.sin(np.pi * np.maximum(np.arange(n) * STEP - 0.3, 0.0))
    values = {"F_s": 9.0, "F_c": 6.0, "v_s": 5e-4, "sigma_0": 4e5, "sigma_1": 4.5e3}
    late = np.concatenate([np.zeros(shift), moves])[: round(8.0 / STEP) + 1]
    runs = {"without": (moves, 0.0), "with": (late, 0.8), "slow": (0.1 * moves[: n // 2], 0.8)}
    for name, (command, share) in runs.items():
        added = share * friction(command, **values)
        drive = {**values, **GAINS, "m": 5.5, "b": 7.0, "T_s": STEP, "encoder": 1e-7}
        shown = simulator.run("lugre", drive, command, F_ff=added)
        columns = {"t [s]": np.arange(len(command)) * STEP, "v_cmd [m/s]": command}
        columns |= {"x_enc [m]": shown["encoder"], "F_motor [N]": shown["commanded"]}
        pd.DataFrame(columns).to_csv(folder / f"{name}.csv", index=False, float_format="%.9g")
    parameters = {name: {"value": x} for name, x in {**values, "m": 5.5, "b": 7.0}.items()}
    document = {"parameters": parameters, "delta": {"value": 1.0}}
    document |= {"share": {"value": 0.8}}
    (folder / "learned.json").write_text(json.dumps(document))
    return folder


LOOP = ["--controller", "PI", "--gain", *(f"{name}={value}" for name, value in GAINS.items())]


def test_the_simulation_predicts_what_the_compensator_brought(logs):
    """Both drives have the same friction and share; they step differently."""
    columns = {"force": Column(name="F_motor")}
    description = Description(columns=columns, controller="PI", gains=GAINS)
    learned = LearnedFile(logs / "learned.json")
    read = [read_log(logs / name, description, learned) for name in ("with.csv", "without.csv")]
    found = compare_logs(*read, learned)
    assert found.repeated
    for key, one in found.measured.reductions.items():
        assert one.value > 0.5
        assert found.simulated.reductions[key].value == pytest.approx(one.value, abs=0.05)
    assert [type(run) for run in found.stretches] == [Overlap]
    assert not found.fault
    assert "inside the measured interval" in sentences(found)[0]
    learned.document["observer"] = {}
    first, _, last = sentences(compare_logs(*read, learned))
    assert last.endswith("observer that the file also has")
    assert first.endswith(" % smaller")
    first, *_ = sentences(compare_logs(*reversed(read), learned))
    assert re.search(r"larger with the compensator, 95 % \[\d.* %, \d.* %\]", first)


def test_swapped_logs_are_told(logs):
    learned = LearnedFile(logs)
    description = Description(columns={"force": Column(name="F_motor")})
    read = [read_log(logs / name, description, learned) for name in ("with.csv", "without.csv")]
    for k, added in enumerate((0.0, 1.0)):
        recording = read[k].reading.recording
        recording = replace(recording, added_force=np.full(len(recording.t), added))
        read[k] = replace(read[k], reading=replace(read[k].reading, recording=recording))
    with pytest.raises(UsageError, match=r"without.csv has an added force, .* look swapped"):
        compare_logs(*read, learned)


def test_the_command_labels_measured_and_simulated(logs, tmp_path, capsys):
    arguments = ["validate", str(logs), "--log", str(logs / "with.csv")]
    arguments += ["--without", str(logs / "without.csv"), "--column", "force=F_motor"]
    assert main([*arguments, *LOOP, "--out", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr().out
    table = pd.read_csv(tmp_path / "out" / "tracking.csv")
    assert list(table.kind.unique()) == ["measured", "simulated"]
    assert sum(line.startswith("Measured ") for line in printed.splitlines()) == 4
    assert sum(line.startswith("Simulated ") for line in printed.splitlines()) == 4
    assert main(["verify", str(tmp_path / "out")]) == 0


def test_without_the_controller_there_is_no_prediction(logs, capsys):
    arguments = ["validate", str(logs / "learned.json"), "--log", str(logs / "with.csv")]
    arguments += ["--without", str(logs / "without.csv"), "--column", "force=F_motor"]
    assert main(arguments) == 0
    assert "simulated" not in capsys.readouterr().out
    arguments[3] = str(logs / "slow.csv")
    assert main(arguments) == 1
    error = capsys.readouterr().err
    assert "differ: the same for" in error
    assert len(error.splitlines()) == 1
