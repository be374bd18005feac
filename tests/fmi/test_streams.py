"""Standard streams that are closed do not lend their numbers to files."""

import os
import subprocess
import sys

import pytest

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="closes file descriptors")

SCRIPT = """
import os, sys
sys.path[:0] = {path!r}
from stickslip.fmi.process import open_standard_streams
open_standard_streams()
for number in range(3):
    assert os.get_inheritable(number)
print("printed")
print("printed", file=sys.stderr)
sys.stdout.flush()
assert sys.stdin.read() == ""
assert os.open({out!r}, os.O_CREAT | os.O_WRONLY) > 2
"""


@pytest.mark.parametrize("closed", ["", "0<&-", "1>&-", "2>&-", "0<&- 1>&-", "0<&- 1>&- 2>&-"])
def test_closed_streams_become_the_null_device(tmp_path, closed):
    script, out = tmp_path / "script.py", tmp_path / "out"
    script.write_text(SCRIPT.format(path=sys.path, out=str(out)))
    command = f"{sys.executable} {script} {closed}"
    done = subprocess.run(command, shell=True, input="", capture_output=True, text=True)  # noqa: S602
    assert done.returncode == 0, done.stderr
    assert out.read_bytes() == b""
    assert done.stdout == ("" if "1>" in closed else "printed\n")
    assert done.stderr == ("" if "2>" in closed else "printed\n")
    assert os.fstat(0)
