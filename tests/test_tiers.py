"""The tiers of tests: each runs what it says, or ends with an error."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def pytest_run(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *arguments],
        cwd=ROOT,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="the tests of other platforms need POSIX")
def test_other_platforms_fail_where_an_emulator_is_missing(tmp_path):
    done = pytest_run("-m", "platforms", "tests/platforms", PATH=str(tmp_path))
    assert done.returncode == 1
    (line,) = (
        line for line in done.stderr.splitlines() + done.stdout.splitlines() if "apt" in line
    )
    assert "wine" in line
    assert "missing; install: apt-get install" in line
