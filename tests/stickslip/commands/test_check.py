"""``stickslip check``: what it prints and how it ends."""

import json

import pytest

import stickslip as ss
from stickslip import models
from stickslip.cli import main
from tests.corpus.defects import binaries
from tests.cosim.single import edited


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    return models.build_fmu("stage", tmp_path_factory.mktemp("check"), fmi=3)


@pytest.fixture
def broken(sound, tmp_path):
    """The same FMU with a unit that nothing defines, and one warning."""
    return edited(sound, tmp_path / "broken.fmu", {'unit="kg"': 'unit="stone"'})


def test_an_error_ends_with_status_1_and_prints_what_to_do(broken, capsys):
    assert main(["check", str(broken)]) == 1
    out = capsys.readouterr().out
    assert "undefined-unit" in out
    assert "unit 'stone' is not defined" in out
    assert "define it in UnitDefinitions  [FMI 3.0.2, 2.4.3]" in out


def test_json_has_every_file_and_finding(sound, broken, capsys):
    assert main(["check", str(sound)]) == 0
    assert "FMI 3.0, 0 errors, 0 warnings" in capsys.readouterr().out
    assert main(["check", str(sound), str(broken), "--json"]) == 1
    printed = json.loads(capsys.readouterr().out)
    assert printed["version"] == 1
    first, second = printed["files"]
    assert (first["file"], first["errors"]) == (str(sound), 0)
    finding = next(f for f in second["findings"] if f["rule"] == "undefined-unit")
    words = {"severity", "rule", "place", "message", "section", "advice"}
    assert set(finding) == words | {"count", "others"}
    assert all(f["count"] > len(f["others"]) for f in second["findings"])
    assert finding["severity"] == "error"
    assert second["errors"] == sum(f["severity"] == "error" for f in second["findings"])


@pytest.mark.slow
def test_strict_counts_warnings(sound, tmp_path, capsys):
    misnamed = tmp_path / "stage.zip"
    misnamed.write_bytes(sound.read_bytes())
    assert main(["check", str(misnamed)]) == 0
    assert main(["check", str(misnamed), "--strict"]) == 1
    assert "not-named-fmu" in capsys.readouterr().out


def test_no_run_does_not_load_the_binary(tmp_path, capsys):
    seed = next(seed for seed in binaries.SEEDS if seed.what == "exit")
    path = str(seed.make(tmp_path))
    assert main(["check", path]) == 1
    assert "ends-the-process" in capsys.readouterr().out
    assert main(["check", path, "--no-run"]) == 0


def test_each_fmu_of_a_package_is_checked_and_its_structure(sound, broken, tmp_path, capsys):
    system = ss.System("two")
    system.add("a", sound)
    system.add("b", broken)
    path = ss.write_ssp(system, tmp_path / "two.ssp")
    assert main(["check", str(path), "--no-run", "--json"]) == 1
    package, *inner = json.loads(capsys.readouterr().out)["files"]
    assert (package["file"], package["errors"]) == (str(path), 0)
    assert [one["errors"] for one in inner] == [0, 1] or [one["errors"] for one in inner] == [1, 0]
    assert all(one["file"].startswith(f"{path}/resources/") for one in inner)

    change = {"resources/0_a.fmu": "resources/gone.fmu"}
    cut = edited(path, tmp_path / "cut.ssp", change, "SystemStructure.ssd")
    assert main(["check", str(cut), "--no-run"]) == 1
    out = capsys.readouterr().out
    assert "system-structure" in out
    assert "resources/gone.fmu' is missing from the package" in out
    assert out.count(": FMI 3.0, ") == 2  # its FMUs are checked all the same


def test_a_log_is_told_how_it_is_checked(tmp_path, capsys):
    (log := tmp_path / "axis.csv").write_text("time,position\n")
    assert main(["check", str(log)]) != 0
    assert f"'stickslip learn {log} --check' checks a log" in capsys.readouterr().err
