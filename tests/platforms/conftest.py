"""FMUs run on other platforms than this: linux-arm64 under qemu, Windows under wine."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from stickslip import models
from stickslip.fmi import toolchain
from stickslip.fmi.toolchain import PLATFORMS, Platform
from tests.conformance.conftest import Fmu

STEP = 5e-4  # s
STEPS = 400
HERE = Path(__file__).parent
# What runs a platform's programs here; nothing for our own.
RUNNERS = {
    "x86_64-linux": [],
    "aarch64-linux": ["qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"],
    "x86_64-windows": ["wine"],
}
# What brings them, on Debian and Ubuntu.
PACKAGES = {
    "qemu-aarch64": "qemu-user",
    "/usr/aarch64-linux-gnu": "libc6-arm64-cross",
    "wine": "wine",
}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what lies here, so that only ``pytest -m platforms`` runs it."""
    for item in items:
        if item.path.is_relative_to(HERE):
            item.add_marker(pytest.mark.platforms)


def pytest_collection_finish(session: pytest.Session) -> None:
    """End the session where tests that lie here were asked for and cannot run."""
    asked = any(item.path.is_relative_to(HERE) for item in session.items)
    if not asked or session.config.option.collectonly:
        return
    needed = {
        word
        for platform, words in RUNNERS.items()
        for word in words
        if platform != toolchain.host_platform().tuple and word in PACKAGES
    }
    missing = sorted(word for word in needed if not (shutil.which(word) or Path(word).is_dir()))
    if missing:
        pytest.exit(
            f"programs of other platforms cannot run here, {' and '.join(missing)} missing;"
            f" install: apt-get install {' '.join(PACKAGES[word] for word in missing)}",
            returncode=1,
        )


def run_table(fmu: Fmu, library: str) -> str:
    """Return the table ``run.h``: what the driver feeds and shows."""
    of = {
        role: [k for k, v in enumerate(fmu.model.variables) if role in (v.role, v.type)]
        for role in ("input", "boolean", "state", "derivative", "output")
    }
    known = (of["state"] + of["input"]) if of["derivative"] else []
    reals = [k for k, v in fmu.listed.items() if v.type == "real"]

    def numbers(values: object) -> str:
        return "{" + ", ".join(map(str, values)) + "}"

    fed = (fmu.inputs(n).values() for n in range(STEPS))
    rows = ",\n".join(numbers(map(float.hex, row)) for row in fed)
    return f"""
enum {{ STEPS = {STEPS}, INPUTS = {len(of["input"])}, SHOWN = {len(reals)},
        SWITCHES = {len(of["boolean"])}, KNOWNS = {len(known)},
        UNKNOWNS = {len(of["derivative"] + of["output"])} }};
#define FMI {fmu.version}
#define LIBRARY "{library}"
#define TOKEN "{fmu.description.guid or fmu.description.instantiationToken}"
static const double STEP = {STEP};
static const uint32_t INPUT[] = {numbers(of["input"])};
static const uint32_t SWITCH[] = {numbers(of["boolean"] or [0])};
static const uint32_t KNOWN[] = {numbers(known or [0])};
static const uint32_t UNKNOWN[] = {numbers(of["derivative"] + of["output"])};
static const uint32_t SHOW[] = {numbers(reals)};
static const double FED[STEPS][INPUTS] = {{
{rows}}};
"""


def _compile_driver(folder: Path, platform: Platform) -> Path:
    windows = platform.suffix == ".dll"
    program = folder / ("driver.exe" if windows else "driver")
    headers = resources.files("fmpy") / "c-code"
    bare = ["-nostdlib", "-lcompiler_rt", "-lkernel32"]
    bare += ["-isystem", str(Path(toolchain.__file__).parent / "standalone")]
    zig = str(toolchain.cache_directory() / "zig")
    subprocess.run(
        [
            *(sys.executable, "-m", "ziglang", "cc", "-target", platform.target, "-std=c11"),
            *("-O2", "-ffp-contract=off", "-isystem", str(headers)),
            *(bare if windows else ["-ldl"]),
            *("driver.c", "-o", program.name),
        ],
        cwd=folder,
        check=True,
        env=os.environ | {"ZIG_GLOBAL_CACHE_DIR": zig, "ZIG_LOCAL_CACHE_DIR": zig},
    )
    return program


@pytest.fixture(scope="session")
def emulators(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Return the environment that the emulators run in."""
    prefix = tmp_path_factory.mktemp("wine")
    return os.environ | {"WINEPREFIX": str(prefix), "WINEDEBUG": "-all"}


@pytest.fixture
def run(tmp_path: Path, emulators: dict[str, str]) -> Callable[[str, int, str], np.ndarray]:
    """Run a model on a platform: ``run("stage", 2, "aarch64-linux")`` returns (STEPS, shown)."""

    def run(name: str, version: int, tuple_: str) -> np.ndarray:
        folder = tmp_path / tuple_
        platform = PLATFORMS[tuple_]
        path = models.build_fmu(name, folder, fmi=version, platforms=[platform])
        fmu = Fmu(path, version, name)
        [library] = (fmu.folder / "binaries").glob("*/*")
        # One file: the compiler's own cache does not notice another run.h in another folder.
        text = (HERE / "driver.c").read_text()
        table = run_table(fmu, library.name)
        (folder / "driver.c").write_text(text.replace('#include "run.h"', table))
        shutil.copy(library, folder)
        program = _compile_driver(folder, platform)
        done = subprocess.run(
            [*RUNNERS[tuple_], str(program)], cwd=folder, env=emulators, capture_output=True
        )
        assert done.returncode == 0, done
        return np.frombuffer(done.stdout).reshape(STEPS, -1)

    return run
