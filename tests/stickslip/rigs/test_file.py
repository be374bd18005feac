"""A rig that a TOML file describes, in Python and for the commands that take ``--rig``."""

import json

import numpy as np
import pytest

import stickslip as ss
from stickslip.cli import main
from stickslip.errors import LimitError, UsageError
from tests.stickslip.rigs.test_socket import command_of, served

RIG = """
socket = "localhost:{port}"

[datasheet]
mass = 5.5
peak_force = 205.0
encoder_step = 4e-7

[limits]
travel = [-0.12, 0.12]
speed = 0.2
force = 120.0
following_error = 2e-3

[experiment]
stroke = 0.05
"""
FRICTION = {"F_s": 8.9, "F_c": 6.0, "v_s": 5.6e-4, "sigma_0": 3.9e5, "sigma_1": 4400.0, "b": 6.6}


BENCH = """
import numpy as np
from stickslip import Log, Rig

class Bench(Rig):
    def __init__(self, place, datasheet, limits, law, *, friction=8.0, axis="x"):
        super().__init__(datasheet, 5e-4, limits, law)
        self.name, self._F = f"{place} {axis}", friction

    def move(self, command):
        x = np.concatenate([[0.0], np.cumsum(command.velocity[:-1])]) * self.T_s
        return Log(np.arange(len(x)) * self.T_s, x, self._F * np.sign(command.velocity))
"""


@pytest.fixture
def described(tmp_path):
    """Return a function that writes the file of a rig at a port."""

    def write(port):
        path = tmp_path / "rig.toml"
        path.write_text(RIG.format(port=port))
        return path

    return write


@pytest.fixture
def learned(tmp_path):
    path = tmp_path / "learned.json"
    values = {name: {"value": value} for name, value in FRICTION.items()}
    path.write_text(json.dumps({"parameters": values}))
    return path


def test_a_file_gives_the_rig_its_limits_and_the_experiment(fmus, described):
    with served(fmus) as (_, port):
        rig, limits = ss.open_rig(described(port))
        with rig:
            expected = ss.Datasheet(5.5, 205.0, encoder_step=4e-7, force_noise=0.0)
            assert rig.datasheet == expected
            assert limits == ss.Limits(stroke=0.05)
            assert len(rig.run(command_of(rig)).t) == 450
            with pytest.raises(LimitError, match=r"force 150 N; expected at most 120 N"):
                rig.push(np.full(10, 150.0))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "socket",
            "bus",
            "expected one key that names an installed kind of rig (socket); got 'bus'",
        ),
        ('socket = "localhost:1"', "socket = 5020", "socket = 5020: expected a text"),
        ("[datasheet]", 'retry = "soon"\n[datasheet]', "retry = 'soon': expected a number"),
        ("[datasheet]", 'symbol = "MAIN.rig"\n[datasheet]', "no key 'symbol'"),
        ("force = 120.0", "", "limits.force is missing; expected a number, in SI units"),
        ("force = 120.0", "forces = 120.0", "limits.force is missing"),
        ("mass = 5.5", "mass = true", "datasheet.mass = True: expected a number"),
        ("mass = 5.5", "mass = 5.5\nmas = 1", "no key 'datasheet.mas'; did you mean 'mass'"),
        ("[-0.12, 0.12]", "[0.12]", "limits.travel = [0.12]: expected [lowest, highest]"),
        ("[-0.12, 0.12]", "[0.1, 0.12]", "expected a range around 0"),
        ("stroke = 0.05", "stroke = -1", "stroke = -1: expected more than 0"),
        ("[experiment]", "[experiment", "not TOML"),
    ],
)
def test_a_wrong_file_is_one_line_and_nothing_is_asked(tmp_path, old, new, said):
    path = tmp_path / "rig.toml"
    path.write_text(RIG.format(port=1).replace(old, new, 1))
    with pytest.raises(UsageError) as fault:
        ss.open_rig(path)
    assert str(fault.value).startswith(f"{path}: ")
    assert said in str(fault.value)
    assert "\n" not in str(fault.value)


def test_validate_runs_both_motions_on_the_drive_once(fmus, described, learned, tmp_path, capsys):
    with served(fmus) as (drive, port):
        out = tmp_path / "validated"
        given = ["validate", learned, "--rig", described(port), "--out", out, "--json"]
        tables, motions = [], []
        for _ in range(2):
            assert main([str(word) for word in given]) == 0
            tables.append(json.loads(capsys.readouterr().out)["validation"])
            motions.append(drive.motion)
        assert motions[0] == motions[1] >= 2
        assert tables[0] == tables[1]
        for row in tables[0]:
            assert row["velocity"] == "measured"
            assert row["with"] < 0.7 * row["without"]
    assert len(list((out / "motions").glob("*.npz"))) == 2


def test_a_package_of_others_adds_a_kind_of_rig(tmp_path, learned, monkeypatch, capsys):
    (tmp_path / "bench.py").write_text(BENCH)
    (tmp_path / "bench-1.0.dist-info").mkdir()
    names = "[stickslip.rigs]\nbench = bench:Bench\nbroken = bench:Absent\n"
    (tmp_path / "bench-1.0.dist-info" / "entry_points.txt").write_text(names)
    monkeypatch.syspath_prepend(tmp_path)
    path, out = tmp_path / "rig.toml", tmp_path / "validated"

    def validate(key):
        path.write_text(RIG.replace('socket = "localhost:{port}"', key))
        return main(["validate", str(learned), "--rig", str(path), "--out", str(out)])

    assert validate('bench = "rack 2"\nfriction = 7.5\naxis = "y"') == 0
    for log in (out / "motions").glob("*.npz"):
        assert set(np.abs(np.load(log)["F_m"])) == {0.0, 7.5}
    for key, said in (
        ('bench = "rack 2"\naxis = 2', "axis = 2: expected a text"),
        ('bench = "rack 2"\nlaw = "dahl"', "no key 'law'"),
        ('broken = "rack 2"', "bench:Absent cannot be imported"),
        ('bus = "rack 2"', "kind of rig (bench, broken, socket); got 'bus'"),
        ('socket = "localhost:1"\nbench = "rack 2"', "socket); got 'socket', 'bench'"),
    ):
        capsys.readouterr()
        assert validate(key) != 0
        assert said in capsys.readouterr().err


@pytest.mark.thorough
def test_learn_takes_a_rig_instead_of_a_log(fmus, described, tmp_path, monkeypatch, capsys):
    asked = []

    def learn(source, _, *, limits, **__):
        asked.append((source.run(command_of(source)), limits))
        raise UsageError("far enough")

    monkeypatch.setattr("stickslip.studies.learn.log_learning.learn", learn)
    with served(fmus) as (drive, port):
        given = ["learn", "--rig", str(described(port)), "--out", str(tmp_path / "out")]
        for _ in range(2):  # the second goes on with the log of the first
            assert main(given) != 0
            assert drive.motion == 1
        assert asked[1][1] == ss.Limits(stroke=0.05)
        np.testing.assert_array_equal(asked[0][0].x_enc, asked[1][0].x_enc)
        capsys.readouterr()
        for wrong in (["log.csv"], ["--check"], ["--tau-i", "1e-4"]):
            assert main([*given, *wrong]) != 0
            assert "--rig: expected no log" in capsys.readouterr().err
        assert drive.motion == 1
    assert main(given) != 0
    assert "connection lost" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["mass", "peak_force", "encoder_step"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf"), "5"])
def test_a_datasheet_has_finite_values_above_0(name, value):
    with pytest.raises(UsageError, match=rf"datasheet\.{name} = {value}: expected a finite number"):
        ss.Datasheet(**{name: value})
