"""FMUs that leave something out, or are called otherwise than usual, run all the same."""

import re

from stickslip import cosim
from stickslip.simulation import simulate
from tests.cosim.single import repacked


def described(path, other, *changes):
    """Return a copy of an FMU whose description was changed by regular expressions."""

    def change(name, content):
        text = content.decode() if name == "modelDescription.xml" else None
        for old, new in changes if text else ():
            assert re.search(old, text)
            text = re.sub(old, new, text)
        return text.encode() if text else content

    return repacked(path, other, change)


def gained(path):
    """Return the result of three times two."""
    return simulate(path, stop=0.1, step=0.1, parameters={"k": 3.0}, inputs={"u": 2.0})


def test_missing_dependencies_mean_all_inputs(make, tmp_path):
    dependencies = ('index="2" dependencies="1"', 'index="2"')
    path = described(make("gain"), tmp_path / "changed.fmu", dependencies)
    assert cosim.Fmu(path).feedthrough["y"] == {"u"}


def test_an_identifier_with_a_hyphen_names_a_file_all_the_same(make, tmp_path):
    identifier = ('modelIdentifier="gain"', 'modelIdentifier="2-gain"')
    path = described(make("gain"), tmp_path / "2-gain.fmu", identifier)
    repacked(path, path, lambda _, content: content, lambda name: name.replace("/gain", "/2-gain"))
    assert gained(path)["2-gain.y"][-1] == 6.0


def test_an_fmu_without_outputs_shows_its_local_variables(make, tmp_path, version):
    unlisted = ("<Outputs>.*</Outputs>|<Output [^>]*/>", "")
    path = described(
        make("gain", version), tmp_path / "gain.fmu", ('"output"', '"local"'), unlisted
    )
    result = gained(path)
    assert result["gain.y"][-1] == 6.0
    assert all(
        cosim.Fmu(path).variables[n.removeprefix("gain.")].causality != "parameter"
        for n in result.names[1:]
    )
