"""Published drives have all that a drive FMU needs, move as they should, and go out to MuJoCo."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from stickslip import models
from stickslip.catalog.parameters import DRIVE
from stickslip.cli import main
from stickslip.drives.published import Drive
from stickslip.drives.robots import robot_model
from stickslip.errors import UsageError
from stickslip.learned.writing import LOOP_UNITS
from tests.kept import further

ROOT = Path(__file__).parents[3]
LEARNED = ROOT / "results" / "paper" / "learned.json"
T = 1e-3
"""Step [s] over which forces are held."""


@pytest.fixture
def mujoco():
    return pytest.importorskip("mujoco", reason="MuJoCo is not installed")


def in_mujoco(mujoco, path, force):
    """Return the positions (n,) of a model at the times of the forces (n,)."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data, steps = mujoco.MjData(model), round(T / model.opt.timestep)
    assert steps * model.opt.timestep == pytest.approx(T)
    x = []
    for data.ctrl[0] in force:
        x.append(data.qpos[0])
        for _ in range(steps):
            mujoco.mj_step(model, data)
    return np.array(x)


def changed(name, **values):
    one = ss.drive(name)
    return replace(one, values={**one.values, **values})


@pytest.mark.parametrize(("error", "kept"), [(0.4, True), (0.6, False)])
def test_a_constant_force_that_a_log_does_not_tell_from_none_is_left_out(tmp_path, error, kept):
    document = json.loads(LEARNED.read_text())
    document["F_0"] = {"value": 1.0, "unit": "N", "standard_error": error}
    path = tmp_path / "learned.json"
    path.write_text(json.dumps(document))
    assert Drive.learned(path).values["F_0"] == (1.0 if kept else 0.0)


@pytest.mark.parametrize(
    ("one", "tolerance"),
    [
        pytest.param(changed("stage", delta=2.0), 0.002, id="LuGre, exponent 2"),
        pytest.param(Drive.learned(LEARNED), 0.01, id="learned, exponent 1"),
        pytest.param(replace(ss.drive("canudas-1995"), rotary=True), 0.002, id="rotary"),
        pytest.param(ss.drive("emps"), 0.005, id="Coulomb and a constant force"),
        *further(
            (changed("stage", delta=2.0, sigma_1=91.0), 0.015),
            (changed("stage", delta=2.0, sigma_1=5.7e4), 0.005),
            (ss.drive("stage"), 0.01),
            (ss.drive("puma560-1"), 0.005),
        ),
    ],
)
def test_mujoco_goes_where_the_drive_goes(tmp_path, mujoco, one, tolerance):
    """Within a share of the travel: slow through break-away, fast, in steps, and below it."""
    path, t = ss.export_drive(one, tmp_path), np.arange(0.0, 2.0, T)
    F_s = one.values["F_s"]
    slow, fast = 1.05 * np.sin(np.pi * t), 2.0 * np.sin(2.0 * np.pi * t)
    for shape in (slow, fast, 1.3 * np.sign(fast), 0.3 * fast):
        force = F_s * shape
        run = ss.simulate(one.system(), stop=t[-1], step=T, inputs={"u": force})
        x = run["drive.x"]
        travel = max(np.ptp(x), 1e-3 * F_s / one.values["b"])  # [m], also where it rests
        assert np.abs(in_mujoco(mujoco, path, force) - x).max() <= tolerance * travel


def test_a_law_with_static_friction_and_no_presliding_gets_stiff_bristles(tmp_path, mujoco):
    """It breaks away where the law does; with Coulomb friction alone it would be wrong by half."""
    one, t = ss.drive("mx-64"), np.arange(0.0, 2.0, T)
    force = 2.0 * one.values["F_s"] * np.sin(2.0 * np.pi * t)
    x = ss.simulate(one.system(), stop=t[-1], step=T, inputs={"u": force})["drive.x"]
    found = in_mujoco(mujoco, ss.export_drive(one, tmp_path), force)
    assert np.abs(found - x).max() <= 0.03 * np.ptp(x)
    resting = in_mujoco(mujoco, tmp_path / "mx-64.xml", np.full(500, 0.95 * one.values["F_s"]))
    assert np.abs(resting).max() < 1e-3
    assert np.ptp(resting[250:]) < 1e-9


def test_dahl_is_mujocos_lugre_and_other_laws_say_what_is_left_out():
    stage = ss.drive("stage")
    friction = {name: stage.values[name] for name in ("m", "b", "F_c", "F_s", "v_s", "sigma_0")}
    said = {}
    for law in ("dahl", "gms", "elasto_plastic", "armstrong"):
        one = replace(stage, law=ss.models.load_law(law), values={**friction, "delta": 2.0})
        said[law] = " ".join(robot_model(one, "mjcf").lost)
    assert said["dahl"] == ""
    assert "of GMS friction, C, alpha, kappa are left out" in said["gms"]
    assert "z_ba" in said["elasto_plastic"]
    assert "bristles, which yield by" in said["armstrong"]
    dahl = replace(stage, law=ss.models.load_law("dahl"), values={**friction, "i": 0.5})
    assert robot_model(dahl, "mjcf").lost == ("of Dahl friction, i are left out",)
    late = robot_model(changed("stage", delta=2.0, b=-0.1, delay=1e-3), "mjcf")
    assert late.lost == ("b = -0.1 N.s/m is written as 0", "the delay of 0.001 s is left out")
    assert 'damping="0"' in late.text


@pytest.mark.parametrize(("name", "joint"), [("emps", "slide"), ("erob80-50", "hinge")])
def test_urdf_has_damping_friction_and_inertia(tmp_path, mujoco, name, joint):
    one = ss.drive(name)
    path = ss.export_drive(one, tmp_path, "urdf")
    model = mujoco.MjModel.from_xml_path(str(path))
    found = [model.dof_damping[0], model.dof_frictionloss[0], model.dof_M0[0]]
    assert found == pytest.approx([one.values[key] for key in ("b", "F_c", "m")])
    assert model.jnt_type[0] == getattr(mujoco.mjtJoint, f"mjJNT_{joint.upper()}")
    assert "limits of the joint are placeholders" in path.read_text()


@pytest.mark.parametrize(
    ("F_s", "left"), [(9.0, "F_s, v_s, sigma_0, sigma_1, delta"), (6.0, "sigma_0, sigma_1")]
)
def test_urdf_says_what_of_the_friction_it_leaves_out(F_s, left):
    """Where F_s = F_c, there is no Stribeck curve."""
    lost = robot_model(changed("stage", F_s=F_s, F_c=6.0), "urdf").lost
    assert f"of LuGre friction, {left} are left out" in lost


def test_the_command_writes_the_learned_values_and_warns(tmp_path, capsys):
    command = ["export", "drive", "--parameters", str(LEARNED), "--out", str(tmp_path)]
    assert main(command) == 0
    output = capsys.readouterr()
    assert output.out == f"{tmp_path / 'drive.xml'}\n"
    assert "the exponent 2, not 1" in output.err
    lugre = re.search('lugre="([^"]+)"', (tmp_path / "drive.xml").read_text())[1]
    known = json.loads(LEARNED.read_text())["parameters"]
    order = ("sigma_0", "sigma_1", "F_c", "F_s")
    assert [float(x) for x in lugre.split()[:4]] == pytest.approx(
        [known[name]["value"] for name in order]
    )


def test_a_file_without_mass_is_refused_in_one_line_and_nothing_is_written(tmp_path, capsys):
    document = json.loads(LEARNED.read_text())
    (tmp_path / "learned.json").write_text(json.dumps({"parameters": document["parameters"]}))
    path, out = str(tmp_path / "learned.json"), tmp_path / "new"
    for form in ("mjcf", "urdf"):
        command = ["export", "drive", "--parameters", path, "--as", form, "--out", str(out)]
        assert main(command) == 1
        error = capsys.readouterr().err
        assert "m = 0 kg, expected a value above 0" in error
        assert error.count("\n") == 1
        assert not out.exists()


@pytest.mark.parametrize("name", ss.drive_names())
def test_each_drive_is_described_and_slides_at_the_speed_of_its_friction(name):
    """A constant force u ends at the speed v with u = F_c + b v, far above v_s."""
    one = ss.drive(name)
    assert one.title
    assert one.licence
    assert any(character.isdigit() for character in one.source)
    known = {v.name: v for v in models.load_model("drive", one.law.name).variables}
    assert {*one.values} <= {*known, *DRIVE}
    assert {*one.loop} <= {*LOOP_UNITS}
    least = {"m", "b", *one.law.parameters} - {"delta", "v_d"}
    assert least <= {*one.values}
    assert one.values["F_s"] >= one.values["F_c"] > 0.0
    force = 2.0 * one.values["F_s"]
    stop = 15.0 * one.values["m"] / one.values["b"]
    result = ss.simulate(one.system(), stop=stop, step=stop / 200, inputs={"u": force})
    v = (force - one.values["F_c"] - one.values.get("F_0", 0.0)) / one.values["b"]
    assert result["drive.v"][-1] == pytest.approx(v, rel=1e-4)
    assert result.units["drive.v"] == ("rad/s" if one.rotary else "m/s")


def test_what_is_shown_has_units_and_says_what_is_assumed():
    text = str(ss.drive("emps"))
    assert "95.1089      kg" in text
    assert "K_p = 8557.44 N.s/m, K_x = 160.18 1/s" in text
    assert [line for line in text.splitlines() if "assumed" in line and "v_s" in line]
    assert "0.0191808    N.m.s/rad" in str(ss.drive("mx-64"))


def test_a_name_that_is_not_known_suggests_near_ones(tmp_path, capsys):
    with pytest.raises(UsageError, match="no published drive 'emp'; did you mean 'emps'"):
        ss.drive("emp")
    for words in (["build", "drive"], ["export", "drive"]):
        assert main([*words, "--of", "../emps", "--out", str(tmp_path / "new")]) == 1
        assert capsys.readouterr().err.count("\n") == 1
        assert not (tmp_path / "new").exists()


def test_build_writes_the_drive_and_says_what_is_left_out(tmp_path, capsys):
    out = ["--fmi", "2", "--out", str(tmp_path)]
    assert main(["build", "--of", "emps", *out]) == 0
    variables = ss.Fmu(tmp_path / "drive.fmu").variables
    assert variables["F_0"].start == -3.1648
    assert variables["m"].start == 95.1089
    assert variables["encoder"].start is False
    for wrong in (["build", "stage"], ["build", "drive", "--law", "gms"]):
        assert main([*wrong, "--of", "emps", *out]) == 1
        assert "expected the model drive and no --law" in capsys.readouterr().err
