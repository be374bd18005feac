"""Other people's checkers find nothing."""

import subprocess
import sys

import pytest

CALL = """
import sys
from fmu_manipulation_toolbox.cli.fmutool import fmutool

for path in sys.stdin:
    sys.argv[1:] = ["-input", path.rstrip(), "-check"]
    try:
        status = fmutool()
    except SystemExit as end:
        status = end.code
    print("status", status or 0, flush=True)
"""


@pytest.fixture(scope="module")
def fmutool():
    """Check FMUs one after the other in a process of its own: what it says of each."""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    with subprocess.Popen([sys.executable, "-c", CALL], text=True, **pipes) as process:

        def check(path):
            print(path, file=process.stdin, flush=True)
            said = ""
            while not (line := process.stdout.readline()).startswith("status "):
                assert line, said  # it has ended
                said += line
            assert line == "status 0\n", said
            return said

        yield check
        process.stdin.close()


@pytest.mark.slow
def test_fmu_manipulation_toolbox_finds_nothing(some_fmu, fmutool):
    said = fmutool(some_fmu.path)
    assert f"compliant with FMI-{some_fmu.version}.0" in said
    assert "No semantic error" in said
    assert "ERROR" not in said
    assert "WARNING" not in said
