"""The ring of three FMUs that peers were measured with, against the plain C loop."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import cosim

RING = Path(__file__).parents[3] / "shared" / "ring"


@pytest.fixture(scope="module")
def ring(tmp_path_factory):
    if not (RING / "build_fmus.py").is_file() or shutil.which("gcc") is None:
        pytest.skip("needs the ring's sources beside the repository, and gcc")
    folder = tmp_path_factory.mktemp("ring")
    command = [sys.executable, str(RING / "build_fmus.py"), str(folder)]
    subprocess.run(command, check=True, capture_output=True, env=dict(os.environ))
    system = cosim.System("ring")
    for name in ("ctrl", "plant", "comp"):
        system.add(name, folder / f"{name}.fmu")
    system.connect("ctrl.u", "plant.u")
    system.connect("comp.f", "plant.f")
    system.connect("plant.y", "ctrl.y")
    system.connect("plant.y", "comp.v")
    return system


@pytest.mark.parametrize("record", [None, ["plant.y", "plant.x"]], ids=["all", "some"])
def test_end_values_are_those_of_the_plain_c_loop(ring, record):
    with ring.prepare(
        step=1e-4, stop=10.0, coupling="jacobi", constant_step=True, record=record
    ) as simulation:
        for _ in range(2):
            result = simulation.run()
            assert result["plant.y"][-1] == 0.19999999999999973
            assert result["plant.x"][-1] == 1.9996644444403784
