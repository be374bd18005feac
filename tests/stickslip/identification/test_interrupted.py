"""No signal, whenever it comes, leaves a lock of a pool of runs taken."""

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[3]
STRIDE = 7


@pytest.mark.skipif(sys.platform == "win32", reason="needs SIGTERM")
@pytest.mark.parametrize("how", ["notebook", "command line"])
def test_a_pool_of_runs_ends_whichever_step_is_interrupted(how):
    script = Path(__file__).with_name("interrupted_runs.py")
    done = subprocess.run(
        [sys.executable, script, how, str(STRIDE)],
        env={"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=100,  # it hangs where a lock is never released
    )
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 100 * STRIDE
