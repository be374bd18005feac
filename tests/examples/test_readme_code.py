"""The Python that the README shows runs as it stands."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def said(tmp_path_factory):
    """Return what each piece of code prints."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    printed = []
    for code in re.findall(r"```python\n(.*?)```", text, flags=re.S):
        folder = tmp_path_factory.mktemp("readme")
        done = subprocess.run(
            [sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        printed.append(done.stdout)
    return printed


def test_a_stiffer_loop_errs_less(said):
    errors = [float(x) for x in re.findall(r"error ([\d.]+) mm/s", said[0])]
    assert len(errors) == 3
    assert errors == sorted(errors, reverse=True)


def test_the_notch_comes_back_with_its_poles(said):
    poles = [complex(p.replace(" ", "")) for p in re.findall(r"[\d.]+ *[-+] *[\d.]+j", said[1])]
    expected = np.exp(1e-3 * np.roots([1, 200, 4e4]))
    assert sorted(poles, key=np.imag) == pytest.approx(sorted(expected, key=np.imag), abs=1e-6)
