"""A model.toml or law.toml that cannot be built is refused with file, variable and word."""

import pytest

from stickslip import models
from stickslip.models.export.description import read_model
from stickslip.models.export.law import MODELS, read_law

DOB, DAHL = MODELS / "compensators" / "dob" / "model.toml", MODELS / "laws" / "dahl" / "law.toml"


@pytest.mark.parametrize(
    ("file", "old", "new", "message"),
    [
        (DOB, 'title = "', 'titel = "', "room/model.toml: key 'title' is missing"),
        (DOB, "title = ", "title : ", r"model\.toml: .*line 1"),
        (DOB, '"F_motor"', '"current"', r"\[loop\]: current is unknown"),
        (DOB, '"tau_i" }', '"tau" }', r"\[loop\]: tau is unknown"),
        (DOB, "start = 1.0", "begin = 1.0", "variable share: begin is unknown"),
        (DOB, "start = 1.0", "start = [1.0, 2.0]", "share: 2 start values for 1 elements"),
        (DOB, "start = 1.0", "start = 1.5", "share = 1.5 1 is outside 0"),
        (DOB, 'F_m = "dependent", v_r', 'F_m = "linear", v_r', "variable F: linear is unknown"),
        (DOB, 'force = "F" }', 'force = "G" }', "terminal friction: G is unknown"),
        (DOB, '[inputs.F_in]\nunit = "N"', '[inputs.F_in]\nunit = "V"', "F_in: V is unknown"),
        (DOB, "[inputs.F_in]\n", '[inputs.F_in]\ndisplay = "kN"\n', "F_in: kN is unknown"),
        (DAHL, 'steady = "', 'level = "', "room/law.toml: key 'steady' is missing"),
        (DAHL, 'coordinate = "log"', 'at_least = "F_0"', "sigma_0: F_0 is unknown"),
    ],
)
def test_what_is_wrong_is_named(tmp_path, file, old, new, message):
    folder = tmp_path / "room"
    folder.mkdir()
    text = file.read_text(encoding="utf-8")
    assert old in text
    (folder / file.name).write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(models.DescriptionError, match=message):
        read_law(folder) if file == DAHL else read_model(folder)


def test_a_law_has_no_name_of_the_model(tmp_path):
    folder = tmp_path / "room"
    folder.mkdir()
    law = DAHL.read_text(encoding="utf-8").replace("[parameters.i]", "[parameters.lead]")
    (folder / "law.toml").write_text(law, encoding="utf-8")
    with pytest.raises(models.DescriptionError, match="lead is a variable of the model as well"):
        read_model(models.load_model("compensator").folder, read_law(folder))
