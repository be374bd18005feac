"""Published drives have all that a drive FMU needs, and move as their figures say."""

import pytest

import stickslip as ss
from stickslip import models
from stickslip.catalog.parameters import DRIVE
from stickslip.cli import main
from stickslip.errors import UsageError
from stickslip.learned.writing import LOOP_UNITS


def test_there_are_drives_of_several_sources():
    drives = [ss.drive(name) for name in ss.drive_names()]
    assert len({one.source.partition(",")[0] for one in drives}) >= 6
    assert {one.rotary for one in drives} == {False, True}


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
