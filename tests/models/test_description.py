"""A model.toml or law.toml that cannot be built is refused with file, variable and word."""

import pytest

from stickslip import models
from stickslip.models.export.description import read_model
from stickslip.models.export.law import MODELS, read_law

DOB, DAHL = MODELS / "compensators" / "dob" / "model.toml", MODELS / "laws" / "dahl" / "law.toml"
STATIC = MODELS / "compensators" / "static_feedforward" / "model.toml"


@pytest.mark.parametrize(
    ("file", "old", "new", "message"),
    [
        (DOB, 'title = "', 'titel = "', "room/model.toml: key 'title' is missing"),
        (DOB, "title = ", "title : ", r"model\.toml: .*line 1"),
        (DOB, '"F_motor"', '"current"', r"\[loop\]: current is unknown"),
        (DOB, '"tau_i" }', '"tau" }', r"\[loop\]: tau is unknown"),
        (DOB, "start = 0.0", "begin = 0.0", "variable L_1: begin is unknown"),
        (DOB, "start = 0.0", "start = [1.0, 2.0]", "L_1: 2 start values for 1 elements"),
        (DOB, "start = 0.0", "start = -1.0", "L_1 = -1 N/m/s is outside 0"),
        (DOB, 'F_m = "dependent" }', 'F_m = "linear" }', "variable d_hat: linear is unknown"),
        (STATIC, 'force = "F" }', 'force = "G" }', "terminal friction: G is unknown"),
        (DOB, '[outputs.d_hat]\nunit = "N"', '[outputs.d_hat]\nunit = "V"', "d_hat: V is unknown"),
        (DOB, "[outputs.d_hat]\n", '[outputs.d_hat]\ndisplay = "kN"\n', "d_hat: kN is unknown"),
        (DAHL, 'steady = "', '# "', "room/law.toml: key 'steady' is missing"),
        (DAHL, "passive = ", "passiv = ", "room/law.toml, its keys: passiv is unknown"),
        (DAHL, 'unit = "N/m"', 'unit = "stone"', "room/law.toml, sigma_0: stone is unknown"),
        (DAHL, "passive = true", 'passive = "yes"', "room/law.toml, passive: yes is unknown"),
        (DAHL, 'steady = "coulomb"', 'steady = "columb"', "room/law.toml, steady: columb is"),
        (DAHL, 'coordinate = "log"', 'coordinate = "lgo"', "room/law.toml, sigma_0: lgo is"),
        (DAHL, "start = 3.9162e5", 'start = "x"', "sigma_0: start is 'x', expected a number"),
        (DAHL, 'coordinate = "log"', 'at_least = "F_0"', "sigma_0: F_0 is unknown"),
        (DAHL, 'uses = ["sigma_0", ', 'uses = ["sigma", ', "F_d, uses: sigma is unknown"),
        (DAHL, "uses = []", 'uses = ["F_k"]', "force, uses: F_k is unknown"),
        (DAHL, "", "", "room: expected law.c beside law.toml, got none"),
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
    law = law.replace('"i"]', '"lead"]')
    (folder / "law.toml").write_text(law, encoding="utf-8")
    (folder / "law.c").touch()
    with pytest.raises(models.DescriptionError, match="lead is a variable of the model as well"):
        read_model(models.load_model("compensator").folder, read_law(folder))
