"""Ctrl-C ends the process soon and leaves no folder behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

pytestmark = pytest.mark.slow

# A process that a shell started in the background inherits that SIGINT is ignored.
LISTEN = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
RUN = """
import sys
from stickslip import cosim
system = cosim.System()
for i in range(50):
    system.add(f"x{i}", sys.argv[1], {"u": 1.0})
with system.prepare(step=1e-6, stop=100.0, record=["x0.y"]) as simulation:
    print("ready", flush=True)
    while True:
        simulation.run()
"""
COMPILE = """
from stickslip.fmi import toolchain
lines = "".join(f"int f{i}(int x) {{ return x * {i}; }}\\n" for i in range(20_000))
print("ready", flush=True)
toolchain.shared_library("slow", {"slow.c": lines}, flags=("-Wno-missing-prototypes",))
"""


@pytest.mark.skipif(os.name == "nt", reason="needs SIGINT")
@pytest.mark.parametrize("program", [RUN, COMPILE], ids=["a run", "a compilation"])
def test_nothing_is_left_behind(make, tmp_path, program):
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    cache = tmp_path / "cache"
    environment = {"TMPDIR": str(temporary)}
    if program == COMPILE:  # else the kernel would be compiled
        environment["STICKSLIP_CACHE"] = str(cache)
    process = subprocess.Popen(
        [sys.executable, "-c", LISTEN + program, str(make("integrator"))],
        env=os.environ | environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    with process:
        assert process.stdout.readline() == "ready\n"
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        try:
            _, said = process.communicate(timeout=20)
        finally:
            process.kill()
    assert "KeyboardInterrupt" in said
    assert not list(temporary.iterdir())
    assert not list(cache.rglob(".*"))
