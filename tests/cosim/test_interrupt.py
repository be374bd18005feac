"""Ctrl-C ends the process soon and leaves no folder behind."""

import os
import signal
import subprocess
import sys
import time

import pytest

pytestmark = pytest.mark.slow

# A process that a shell started in the background inherits that SIGINT is ignored.
LISTEN = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
COMPILE = """
from stickslip.fmi import toolchain
lines = "".join(f"int f{i}(int x) {{ return x * {i}; }}\\n" for i in range(20_000))
print("ready", flush=True)
toolchain.shared_library("slow", {"slow.c": lines}, flags=("-Wno-missing-prototypes",))
"""


@pytest.mark.skipif(os.name == "nt", reason="needs SIGINT")
def test_nothing_is_left_behind_of_a_compilation(tmp_path):
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    cache = tmp_path / "cache"
    environment = {"TMPDIR": str(temporary), "STICKSLIP_CACHE": str(cache)}
    process = subprocess.Popen(
        [sys.executable, "-c", LISTEN + COMPILE],
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
