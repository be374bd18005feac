from __future__ import annotations

import zipfile

import numpy as np
import pytest
from fmpy.ssp.ssd import read_ssd, read_ssv
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver

from stickslip import cosim

EXPERIMENT = cosim.DefaultExperiment(start=0.0, stop=2.0, step=0.25)


@pytest.fixture
def loop(make):
    system = cosim.System("loop")
    system.add("controller", make("gain"), {"k": -0.5, "n": 3, "flag": True, "text": "a<b"})
    system.add("drive", make("integrator"), {"k": 1.0})
    system.add("watch", make("gain"))
    system.connect("drive.y", "controller.u")
    system.connect("controller.y", "drive.u")
    system.expose("force", "watch.u")
    return system


@pytest.fixture
def package(loop, tmp_path):
    return cosim.write_ssp(loop, tmp_path / "loop.ssp", EXPERIMENT)


def run(system):
    with system.prepare(step=EXPERIMENT.step, stop=EXPERIMENT.stop) as simulation:
        return simulation.run(inputs={"force": np.sin})


def test_round_trip(loop, package):
    system, experiment = cosim.read_ssp(package)
    assert experiment == EXPERIMENT
    assert system.name == loop.name
    assert list(system.components) == list(loop.components)
    assert system.connections == loop.connections
    assert system.inputs == loop.inputs
    assert system.parameters == loop.parameters
    np.testing.assert_array_equal(run(system).values, run(loop).values)


def test_the_same_system_gives_the_same_bytes(loop, package, tmp_path):
    again = cosim.write_ssp(loop, tmp_path / "again.ssp", EXPERIMENT)
    assert again.read_bytes() == package.read_bytes()
    system, experiment = cosim.read_ssp(package)
    assert cosim.write_ssp(system, again, experiment).read_bytes() == package.read_bytes()


def test_fmpy_finds_it_valid_and_reads_the_same(package):
    ssd = read_ssd(str(package))
    assert [c.name for c in ssd.system.elements] == ["controller", "drive", "watch"]
    values = read_ssv(str(package), "resources/0_controller.ssv")
    assert {p.name: p.value for p in values.parameters}["k"] == "-0.5"


def test_libcosim_runs_it_to_the_values_of_our_jacobi(make, tmp_path):
    system = cosim.System("oscillator")
    system.add("spring", make("gain"), {"k": -1.0})
    system.add("speed", make("integrator"), {"k": 0.0})
    system.add("position", make("integrator"), {"k": 1.0})
    system.connect("position.y", "spring.u")
    system.connect("spring.y", "speed.u")
    system.connect("speed.y", "position.u")
    package = cosim.write_ssp(system, tmp_path / "a.ssp", EXPERIMENT)
    ours = system.prepare(step=0.25, stop=2.0, coupling="jacobi").run()

    execution = CosimExecution.from_ssp_file(str(package))  # the step is in the package
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    execution.simulate_until(2_000_000_000)  # ns
    for name in ("spring", "speed", "position"):
        slave = execution.slave_index_from_instance_name(name)
        (value,) = observer.last_real_values(slave, [1])
        assert value == pytest.approx(ours[f"{name}.y"][-1], abs=1e-12)


def changed(package, tmp_path, old, new, member="SystemStructure.ssd"):
    path = tmp_path / "changed.ssp"
    with zipfile.ZipFile(package) as source, zipfile.ZipFile(path, "w") as target:
        for name in source.namelist():
            data = source.read(name)
            if name == member:
                assert old.encode() in data
                data = data.replace(old.encode(), new.encode())
            target.writestr(name, data)
    return path


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('version="1.0"', 'version="3.0"', r"version is '3\.0', expected '1\.0' or '2\.0'"),
        ("<ssd:System ", "<ssd:Sistem ", "SystemStructure"),
        ('endElement="drive"', 'endElement="drove"', "no component 'drove'.*mean 'drive'"),
        ('source="resources/1_drive.fmu"', 'source="../drive.fmu"', "outside the package"),
        ('source="resources/1_drive.fmu"', 'source="http://x/drive.fmu"', "outside the package"),
        ('source="resources/1_drive.fmu"', 'source="resources/x.fmu"', "missing from the package"),
        ('startConnector="force"', 'startConnector="farce"', "no connector 'farce'"),
    ],
)
def test_packages_that_cannot_be(package, tmp_path, old, new, message):
    path = changed(package, tmp_path, old, new)
    with pytest.raises(cosim.SspError, match=message) as error:
        cosim.read_ssp(path)
    assert str(path) in str(error.value)


def test_a_parameter_in_another_unit_is_refused(make, tmp_path):
    system = cosim.System()
    system.add("a", make("gain"), {"fault_time": 1.0})
    package = cosim.write_ssp(system, tmp_path / "a.ssp")
    path = changed(
        package, tmp_path, 'value="1.0" unit="s"', 'value="1.0" unit="m"', "resources/0_a.ssv"
    )
    with pytest.raises(cosim.SspError, match=r"line 4: .*in 'm', which cannot be .* to 's'"):
        cosim.read_ssp(path)


def test_a_connection_may_be_written_from_its_end(package, tmp_path):
    new = 'startElement="controller" startConnector="u" endElement="drive" endConnector="y"'
    with zipfile.ZipFile(package) as file:
        text = file.read("SystemStructure.ssd").decode()
    found = next(line for line in text.splitlines() if 'endElement="controller"' in line).strip()
    assert 'startElement="drive"' in found
    path = changed(package, tmp_path, found, f"<ssd:Connection {new}/>")
    assert cosim.read_ssp(path)[0].connections["controller.u"] == "drive.y"


def test_no_package(tmp_path):
    (tmp_path / "a.ssp").write_text("no zip")
    with pytest.raises(cosim.SspError, match="not a zip archive"):
        cosim.read_ssp(tmp_path / "a.ssp")
