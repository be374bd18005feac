"""Every example runs as a user runs it, and what it prints is so."""

import os
import re
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from stickslip import cosim

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
NUMBER = r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?"
NAMES = ["closed_loop", "learn_parameters"]


def run(name: str, work: Path, *arguments: str) -> str:
    """Run an example in an empty working folder, which must stay empty; return its output."""
    work.mkdir()
    path = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
    done = subprocess.run(
        [sys.executable, ROOT / "examples" / f"{name}.py", *arguments],
        cwd=work,
        env={**os.environ, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert not done.stderr
    assert not list(work.iterdir())
    return done.stdout


Example = Callable[[str], tuple[Path, str]]


@pytest.fixture(scope="module")
def example(tmp_path_factory: pytest.TempPathFactory) -> Example:
    """Return the folder that an example was given, and its output; each is run once."""

    @cache
    def example(name: str) -> tuple[Path, str]:
        folder = tmp_path_factory.mktemp(name)
        return folder / "out", run(name, folder / "work", str(folder / "out"))

    return example


def find(pattern: str, text: str) -> list[float]:
    match = re.search(pattern.replace("#", f"({NUMBER})"), text)
    assert match, f"no {pattern!r} in:\n{text}"
    return [float(group) for group in match.groups()]


def test_every_example_is_tested():
    assert sorted(path.stem for path in (ROOT / "examples").glob("*.py")) == sorted(
        [*NAMES, "real_drive"]  # in tests/stickslip/rigs/test_socket.py
    )


@pytest.mark.parametrize("name", NAMES)
def test_draws_a_picture_and_says_where(example, name):
    folder, output = example(name)
    picture = folder / f"{name}.png"
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert picture.stat().st_size > 20_000
    assert f"written: {picture}" in output


def test_closed_loop(example):
    folder, output = example("closed_loop")
    samples = pd.read_csv(folder / "closed_loop.csv")
    error = 1e3 * (samples["v_cmd"] - samples["drive.v"]).abs().max()
    (full,) = find(r"trapezoid +largest velocity error # mm/s", output)
    (less,) = find(r"F_c = 1 N +largest velocity error # mm/s", output)
    assert full == pytest.approx(error, abs=1e-3)
    assert 0.0 < less < 0.7 * full < 5.0
    system, experiment = cosim.read_ssp(folder / "loop.ssp")
    samples = cosim.Table.all_from_csv(folder / "closed_loop.csv")
    with system.prepare(step=experiment.step, stop=experiment.stop) as simulation:
        result = simulation.run(inputs={"v_cmd": samples["v_cmd"]})
    np.testing.assert_array_equal(result["drive.v"], samples["drive.v"].sample(result.time))


def test_learn_parameters(example):
    _, output = example("learn_parameters")
    for gene in ("stage.F_c", "stage.sigma_0"):
        learned, true, percent = find(rf"{gene} +learned # \S+, true # \(# %\)", output)
        assert learned == pytest.approx(true, rel=0.02)
        assert percent == pytest.approx(100 * (learned / true - 1), abs=0.01)
    best, first = find(r"best cost # nm RMS, # um at first", output)
    assert 1e-9 * best < 1e-3 * (1e-6 * first)
