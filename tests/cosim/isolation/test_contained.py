"""What an FMU does to its process, it does to the child."""

import gc
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from stickslip import cosim
from stickslip.cosim.control import linearise
from tests.corpus.hostile import fmus
from tests.cosim.single import one
from tests.kept import further

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc"),
]

LIMITS = cosim.Isolation(timeout=60.0)


def processes() -> dict[int, tuple[str, int, int]]:
    """Return state, parent and group of every process."""
    found = {}
    for folder in Path("/proc").iterdir():
        with suppress(OSError, ValueError):  # it has just ended, or is another kind of folder
            state, parent, group = (folder / "stat").read_text().rpartition(")")[2].split()[:3]
            found[int(folder.name)] = state, int(parent), int(group)
    return found


def below() -> set[int]:
    """Return the processes below this one, also those that are dead but not waited for."""
    every, found = processes(), set[int]()
    new = {os.getpid()}
    while new:
        new = {child for child, (_, parent, _) in every.items() if parent in new}
        found |= new
    return found


@pytest.fixture
def children():
    """Return a function for the processes below this one that the test has started."""
    before = below()
    return lambda: below() - before


def open_files() -> int:
    return len(list(Path("/proc/self/fd").iterdir()))


def run(system, limits=LIMITS, **arguments):
    with system.prepare(step=0.01, stop=0.1, isolation=limits) as simulation:
        return simulation.run(**arguments)


@pytest.mark.parametrize(
    "behaviour",
    [
        "DoStep chdir", "DoStep locale", "load flush", "Instantiate round", "load signals",
        "DoStep fork 3", "DoStep daemon", "DoStep chat", "DoStep chat_astray",
        "DoStep close_standard",
    ],
)  # fmt: skip
def test_what_it_changes_is_left_behind(hostile, children, behaviour):
    here, files = (Path.cwd(), signal.getsignal(signal.SIGINT)), open_files()
    result = run(hostile(behaviour))
    assert np.allclose(result["plant.y"], 0.01 * np.arange(11))
    assert (Path.cwd(), signal.getsignal(signal.SIGINT)) == here
    assert sys.float_info.min / 2 > 0
    assert not children()
    assert open_files() == files


def test_the_next_run_has_another_child(hostile, children):
    """A tenth of all k crash where fragile is set."""
    with hostile().prepare(step=0.01, stop=0.1, isolation=LIMITS) as simulation:
        for k, fragile, dies in [
            (0.5, 1, False),
            (1.01, 1, True),
            (1.01, 0, False),
            (2.0, 1, True),
        ]:
            parameters = {"plant.k": k, "plant.fragile": fragile}
            if dies:
                with pytest.raises(cosim.FmuCrashed, match=r"DoStep died of SIGSEGV at t = 0.06"):
                    simulation.run(parameters)
            else:
                assert simulation.run(parameters)["plant.y"][-1] == pytest.approx(0.1 * k)
            assert len(children()) == (0 if dies else 1)


def test_a_binary_is_never_loaded_here(hostile):
    maps = Path("/proc/self/maps")
    before = maps.read_text().count("hostile.so")  # of other tests
    run(hostile())
    assert maps.read_text().count("hostile.so") == before


@pytest.mark.parametrize(
    ("call", "behaviour"),
    [
        *(("load", "scribble"), ("Instantiate", "scribble_frame"), ("DoStep 5", "mumble")),
        *(("Terminate", "scribble_frame"), ("FreeInstance", "scribble")),
    ],
)
def test_what_it_writes_into_every_file_is_not_an_answer(hostile, call, behaviour):
    """Neither a whole message nor a part of one, after which nothing comes."""
    name, *count = call.split()
    with pytest.raises(cosim.FmuCrashed, match="wrote into files that are not its own"):
        run(hostile(" ".join([name, behaviour, *count])), cosim.Isolation(timeout=10.0))


def test_the_time_limit_holds_while_progress_is_reported(hostile):
    """A hundred reports would take 10 s."""
    limits, reported = cosim.Isolation(timeout=1.0), []

    def report(t):
        reported.append(t)
        time.sleep(0.1)

    with (
        hostile().prepare(step=0.001, stop=1.0, isolation=limits) as simulation,
        pytest.raises(cosim.FmuCrashed, match=r"when the 1 s for all were over"),
    ):
        simulation.run(progress=report)
    assert reported


def test_a_step_has_a_limit_of_its_own(hostile):
    with pytest.raises(cosim.FmuCrashed, match=r"DoStep did not return within 0\.4 s"):
        run(hostile("DoStep hang 3"), cosim.Isolation(patience=0.4))


def test_nothing_is_left_of_many_crashes(hostile, children):
    with pytest.raises(cosim.FmuCrashed):
        run(hostile("DoStep segv"))
    gc.collect()
    files, memory = open_files(), Path("/proc/self/maps").read_text().count("memfd:stickslip")
    for _ in range(3):
        with pytest.raises(cosim.FmuCrashed):
            run(hostile("DoStep segv"))
    gc.collect()
    assert open_files() == files
    assert Path("/proc/self/maps").read_text().count("memfd:stickslip") == memory
    assert not children()


def test_who_forgets_to_close_leaves_nothing(hostile, children):
    simulation = hostile("DoStep daemon").prepare(step=0.01, stop=0.1, isolation="process")
    simulation.run()
    (child,) = (pid for pid in children() if os.getpgid(pid) == pid)
    del simulation
    gc.collect()
    assert is_gone(child)


SCRIPT = """
import os, signal, sys, cosim
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have taken it away
system = cosim.System("loop")
system.add("plant", sys.argv[1])
simulation = system.prepare(step=0.01, stop=0.1, isolation="process")
print(simulation._process._process.pid, flush=True)
print(simulation.run()["plant.y"][-1], flush=True)
"""


def start(hostile, behaviour):
    path = hostile(behaviour).components["plant"].path
    own = os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    return subprocess.Popen(
        [sys.executable, "-c", SCRIPT, path], stdout=subprocess.PIPE, stderr=-3, env=own
    )


def is_gone(group, seconds=10.0):
    end = time.monotonic() + seconds
    while any(g == group and state != "Z" for state, _, g in processes().values()):
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


def test_a_script_needs_no_guard(hostile):
    with start(hostile, "") as process:
        child, last = process.stdout.read().split()
    assert process.returncode == 0
    assert float(last) == pytest.approx(0.1)
    assert is_gone(int(child))


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL, *further(signal.SIGTERM)])
def test_it_ends_with_its_parent_however_that_ends(hostile, number):
    with start(hostile, "DoStep hang") as process:
        child = int(process.stdout.readline())
        process.send_signal(number)
        process.wait(30)
    assert process.returncode != 0
    assert is_gone(child)


def test_what_this_installation_compiled_runs_here_and_what_is_foreign_in_a_child(tmp_path):
    """By default; one byte makes a binary foreign."""
    binaries = {fmus.place(): fmus.library() + b"\0"}
    path = fmus.write(tmp_path / "foreign.fmu", "DoStep segv 3", binaries=binaries)
    system = one(path)
    with (
        system.prepare(step=0.01, stop=0.1) as simulation,
        pytest.raises(cosim.FmuCrashed, match=r"died of SIGSEGV at t = 0\.02"),
    ):
        simulation.run()
    assert system.prepare(step=0.01, stop=0.1, isolation=None).spec.limits is None
    with pytest.raises(cosim.FmuCrashed, match="fmi2DoStep died of SIGSEGV"):
        linearise(path, step=0.01)
    known = one(fmus.write(tmp_path / "known.fmu"))
    assert cosim.Specification(known, 0.01, 0.1).limits is None
    packed = one(cosim.write_fmu(known, tmp_path / "packed.fmu", step=0.01))
    assert cosim.Specification(packed, 0.01, 0.1).limits == cosim.Isolation()


def test_every_preparation_finds_the_resources_that_were_packed(tmp_path):
    """An FMU that writes into its unpacked files, with one Fmu object, spoils no later run."""

    def behaviour(fmu):
        return (fmu.folder / "resources" / "behaviour.txt").read_text()

    path = fmus.write(tmp_path / "writer.fmu", "DoStep rewrite")
    fmu = cosim.Fmu(path)
    limits = cosim.Isolation(allow=(f"files={fmu.folder}",))
    for _ in range(3):
        with one(fmu).prepare(step=0.01, stop=0.1, isolation=limits) as simulation:
            assert behaviour(fmu) == "DoStep rewrite"
            simulation.run()
        assert behaviour(fmu) == "DoStep abort  "
    assert behaviour(cosim.Fmu(path)) == "DoStep rewrite"
