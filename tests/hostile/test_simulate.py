"""``simulate`` runs FMUs of others in processes of their own by default."""

import subprocess
import sys

import pytest

from stickslip.cli import main
from tests.corpus.hostile import fmus

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="apart by default on Linux only"),
]


def test_an_fmu_that_ends_its_process_does_not_end_the_command(tmp_path, capfd, monkeypatch):
    monkeypatch.setattr("stickslip.fmi.toolchain.compiled_here", lambda _: False)
    path = fmus.write(tmp_path / "quits.fmu", "DoStep exit0 3")
    assert main(["simulate", str(path)]) == 1
    assert "DoStep ended its process with status 0" in capfd.readouterr().err


def test_limits_need_something_to_limit(tmp_path, capfd):
    path = fmus.write(tmp_path / "sound.fmu")
    assert main(["simulate", str(path), "--no-isolate", "--timeout", "5"]) == 1
    assert "--timeout needs --isolate" in capfd.readouterr().err


@pytest.mark.parametrize("how", ["--isolate", "--no-isolate"])
def test_closed_standard_streams_change_nothing(tmp_path, how):
    path, out = fmus.write(tmp_path / "prints.fmu", "DoStep scribble_standard"), tmp_path / "o.csv"
    command = f"{sys.executable} -m stickslip simulate {path} {how} --out {out} 0<&- 1>&- 2>&-"
    done = subprocess.run(command, shell=True, capture_output=True, text=True)  # noqa: S602
    assert done.returncode == 0, done.stderr
    assert out.read_text().startswith("time,u,hostile.y\n")
    assert "Traceback" not in done.stderr
