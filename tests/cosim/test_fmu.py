"""What is no FMU for this machine ends in one clear line, and leaves nothing behind."""

import pickle
import re
import zipfile

from stickslip import cosim
from stickslip.simulation import simulate


def members(path):
    with zipfile.ZipFile(path) as file:
        return {name: file.read(name) for name in file.namelist()}


def pack(path, content):
    with zipfile.ZipFile(path, "w") as file:
        for name, data in content.items():
            file.writestr(name, data)
    return path


def replaced(make, tmp_path, old, new, version=2):
    content = members(make("gain", version))
    xml = content["modelDescription.xml"].decode()
    assert old in xml
    content["modelDescription.xml"] = xml.replace(old, new).encode()
    return pack(tmp_path / "changed.fmu", content)


def test_description(make, version):
    fmu = cosim.Fmu(make("gain", version))
    assert (fmu.name, fmu.version, fmu.token) == ("gain", version, "gain")
    assert fmu.experiment == cosim.DefaultExperiment(0.0, 1.0, 0.01)
    k = fmu.variables["k"]
    assert (k.causality, k.start, k.minimum, k.maximum) == ("parameter", 1.0, -1000.0, 1000.0)
    assert fmu.variables["u"].unit == "N"
    assert fmu.variables["flag"].start is False
    assert fmu.feedthrough == {"y": {"u"}, "sum": set()}


def test_missing_dependencies_mean_all_inputs(make, tmp_path):
    path = replaced(make, tmp_path, 'index="2" dependencies="1"', 'index="2"')
    assert cosim.Fmu(path).feedthrough["y"] == {"u"}


def test_pickles_as_its_path(make):
    fmu = cosim.Fmu(make("gain"))
    twin = pickle.loads(pickle.dumps(fmu))  # noqa: S301 - our own bytes
    assert twin.path == fmu.path
    assert twin.variables == fmu.variables


def test_is_unpacked_once_and_nothing_else_is_left(make, cache):
    first, second = cosim.Fmu(make("gain")), cosim.Fmu(make("gain"))
    assert first.folder == second.folder
    digest = first.folder.name
    assert {p.name for p in (cache / "fmus").iterdir()} == {digest, f"{digest}.json"}


def test_an_identifier_with_a_hyphen_names_a_file_all_the_same(make, tmp_path):
    content = members(make("gain"))
    (binary,) = (name for name in content if name.startswith("binaries/"))
    text = content["modelDescription.xml"].decode()
    text = text.replace('modelIdentifier="gain"', 'modelIdentifier="2-gain"')
    content["modelDescription.xml"] = text.encode()
    content[binary.replace("/gain", "/2-gain")] = content.pop(binary)
    result = simulate(
        pack(tmp_path / "2-gain.fmu", content),
        stop=0.1,
        step=0.1,
        parameters={"k": 3.0},
        inputs={"u": 2.0},
    )
    assert result["2-gain.y"][-1] == 6.0


def test_an_fmu_without_outputs_shows_its_local_variables(make, tmp_path, version):
    content = members(make("gain", version))
    text = content["modelDescription.xml"].decode().replace('"output"', '"local"')
    text = re.sub(r"<Outputs>.*</Outputs>|<Output [^>]*/>", "", text)
    content["modelDescription.xml"] = text.encode()
    path = pack(tmp_path / "gain.fmu", content)
    result = simulate(path, stop=0.1, step=0.1, parameters={"k": 3.0}, inputs={"u": 2.0})
    assert result["gain.y"][-1] == 6.0
    assert all(
        cosim.Fmu(path).variables[n.removeprefix("gain.")].causality != "parameter"
        for n in result.names[1:]
    )
