"""The C of every FMU runs clean under the address and undefined-behaviour sanitizers."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from stickslip.models.export.sources import fmi_headers
from tests.corpus.fuzz_calls import SANITIZE

pytestmark = pytest.mark.slow


def test_a_whole_life_is_clean(fmu, compiler, tmp_path):
    files = {
        str(path.relative_to(fmu.folder / "sources")): path.read_text()
        for path in (fmu.folder / "sources").rglob("*.[ch]")
    } | {f"system/{path}": text for path, text in fmi_headers(fmu.version).items()}
    files["driver.c"] = Path(__file__).with_name("driver.c").read_text()
    for path, text in files.items():
        (tmp_path / path).parent.mkdir(exist_ok=True)
        (tmp_path / path).write_text(text)
    sources = sorted(path for path in files if path.endswith(".c"))
    build = [compiler, *SANITIZE, f"-DFMI={fmu.version}", "-std=c11", "-ffp-contract=off"]
    built = subprocess.run(
        [*build, "-I.", "-isystem", "system", *sources, "-o", "driver"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert built.returncode == 0, built.stderr
    done = subprocess.run([tmp_path / "driver"], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
