"""Other people's checkers find nothing."""

import subprocess
import sys

import pytest

CALL = "from fmu_manipulation_toolbox.cli.fmutool import fmutool; fmutool()"


@pytest.mark.slow
def test_fmu_manipulation_toolbox_finds_nothing(fmu):
    done = subprocess.run(
        [sys.executable, "-c", CALL, "-input", str(fmu.path), "-check"],
        capture_output=True,
        text=True,
        check=True,
    )
    said = done.stdout + done.stderr
    assert f"compliant with FMI-{fmu.version}.0" in said
    assert "No semantic error" in said
    assert "ERROR" not in said
    assert "WARNING" not in said
