"""``simulate`` runs FMUs of others in processes of their own by default."""

import os
import shutil
import subprocess
import sys

import pytest

from stickslip.cli import main
from stickslip.cosim import kernel
from stickslip.fmi import toolchain
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


def test_a_damaged_kernel_is_built_again(tmp_path, monkeypatch):
    """The next command works; tests/fmi/test_compiler.py damages a library in other ways."""
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache" / "zig").symlink_to(toolchain.cache_directory() / "zig")
    monkeypatch.setenv("STICKSLIP_CACHE", str(tmp_path / "cache"))
    path = fmus.write(tmp_path / "sound.fmu")
    command = [sys.executable, "-m", "stickslip", "simulate", str(path)]
    sound = kernel.built(marked=True)
    damaged = tmp_path / "cache" / "libraries" / sound.parent.name / sound.name
    shutil.copytree(sound.parent, damaged.parent)
    os.truncate(damaged, 1000)
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert damaged.stat().st_size == sound.stat().st_size
