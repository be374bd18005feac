"""What keeps a child's mistakes from its parent, each wall alone."""

import resource
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from stickslip.cosim.isolation.messages import Shared

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")


def in_a_child(code: str, made: Shared, **options: object) -> subprocess.CompletedProcess[str]:
    """Run code in a process that inherits shared memory; it knows ``name`` and ``size``."""
    begin = "import os, sys; from stickslip.cosim.isolation.messages import Shared;"
    begin += "name, size = sys.argv[1], int(sys.argv[2]);"
    return subprocess.run(
        [sys.executable, "-c", begin + code, made.name, str(made.size)],
        pass_fds=made.files,
        capture_output=True,
        text=True,
        check=False,
        **options,
    )


@pytest.fixture
def made():
    made = Shared.make(3)
    yield made
    made.close_files()


@pytest.mark.parametrize("call", ["ftruncate(file, 0)", "pwrite(file, b'x' * 8, 4096)"])
def test_shared_memory_cannot_be_cut_short_or_written_as_a_file(made, call):
    """The first would end the parent by SIGBUS; the second would change results."""
    code = f"file = os.dup(int(name)); Shared.open(name, size); os.{call}"
    done = in_a_child(code, made)
    assert "PermissionError" in done.stderr
    np.testing.assert_array_equal(made.numbers, 0.0)


def test_what_a_child_forks_has_no_part_in_the_results(made):
    code = "shared = Shared.open(name, size); child = os.fork();"
    code += "\nif child == 0: shared.numbers[0] = 7.0"
    code += "\nelse: print(os.WTERMSIG(os.waitpid(child, 0)[1])); shared.numbers[1] = 1.0"
    done = in_a_child(code, made)
    assert done.stdout.strip() == str(int(signal.SIGSEGV)), done.stderr
    np.testing.assert_array_equal(made.numbers, [0.0, 1.0, 0.0])


def test_a_crash_leaves_no_core_file(hostile):
    """Cores of large tools fill a disk within a night of learning."""
    before = resource.getrlimit(resource.RLIMIT_CORE)
    resource.setrlimit(resource.RLIMIT_CORE, (before[1], before[1]))
    try:
        with hostile().prepare(step=0.01, stop=0.1, isolation="process") as simulation:
            process = simulation._process._process.pid
            limits = Path(f"/proc/{process}/limits").read_text()
    finally:
        resource.setrlimit(resource.RLIMIT_CORE, before)
    (line,) = (line for line in limits.splitlines() if "core file" in line)
    assert line.split()[4:6] == ["0", "0"]


@pytest.mark.parametrize("protected", [True, False])
@pytest.mark.parametrize("call", ["Instantiate", "DoStep 3", "Terminate"])
def test_a_forked_copy_of_the_child_does_not_answer(
    hostile, tmp_path, monkeypatch, call, protected
):
    """The FMU returns in both processes, and one answers, also where memory outlives a fork.

    There the copy may still write results while the next run does, so only their number is sure.
    """
    if not protected:  # as on systems that have no MADV_DONTFORK
        (tmp_path / "sitecustomize.py").write_text("import mmap; del mmap.MADV_DONTFORK")
        monkeypatch.syspath_prepend(tmp_path)
    name, *count = call.split()
    system = hostile(" ".join([name, "fork", *count]))
    with system.prepare(step=0.01, stop=0.1, isolation="process") as simulation:
        for k in (1.0, 2.0, 3.0):
            result = simulation.run({"plant.k": k})
            assert len(result["plant.y"]) == 11
            if protected:
                assert result["plant.y"][-1] == pytest.approx(0.1 * k)
