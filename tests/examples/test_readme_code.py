"""The Python of the README and of pages of docs/ runs as it is."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def printed(tmp_path_factory):
    """Return what each piece of code prints."""
    pages = ("README.md", "docs/python.md", "docs/cosimulation.md", "docs/adaptation.md")
    text = "".join((ROOT / page).read_text(encoding="utf-8") for page in pages)
    found = []
    for code in re.findall(r"```python\n(.*?)```", text, flags=re.S):
        folder = tmp_path_factory.mktemp("readme")
        done = subprocess.run(
            [sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        found.append(done.stdout)
    return found


def test_a_sliding_stage_follows_its_closed_form(printed):
    """Constant force and friction: m dv/dt = u - F_c - b v."""
    [velocity] = re.findall(r"([\d.]+) m/s", printed[0])
    m, b, force = 5.557, 6.6135, 12.0 - 4.0
    assert float(velocity) == pytest.approx(force / b * (1 - np.exp(-b / m)), rel=0.01)


def test_a_stiffer_loop_errs_less(printed):
    errors = [float(x) for x in re.findall(r"error ([\d.]+) mm/s", printed[1])]
    assert len(errors) == 3
    assert errors == sorted(errors, reverse=True)


def test_the_search_finds_what_the_sweep_encloses(printed):
    """The velocity at the end is (u - F_c) / b (1 - exp(-b t / m))."""
    table = [line.split() for line in printed[2].splitlines()]
    ends = [float(row[3]) for row in table if len(row) == 4 and row[0].isdigit()]
    m, b = 5.557, 6.6135
    forces = [F_c for F_c in (1.0, 2.0, 4.0) for _ in range(2)]
    masses = 3 * [5.0, 10.0]
    expected = [
        (12.0 - F) / b * (1 - np.exp(-b * 0.5 / m)) for F, m in zip(forces, masses, strict=True)
    ]
    assert ends == pytest.approx(expected, rel=0.02)
    [F_c] = re.findall(r"F_c = ([\d.]+) N gives", printed[2])
    gain = (1 - np.exp(-b * 0.5 / m)) / b
    assert float(F_c) == pytest.approx(12.0 - 0.5 / gain, rel=0.02)


def test_the_notch_comes_back_with_its_poles(printed):
    poles = [complex(p.replace(" ", "")) for p in re.findall(r"[\d.]+ *[-+] *[\d.]+j", printed[3])]
    expected = np.exp(1e-3 * np.roots([1, 200, 4e4]))
    assert sorted(poles, key=np.imag) == pytest.approx(sorted(expected, key=np.imag), abs=1e-6)


def test_errors_of_coupling_fall_with_the_step_and_the_degree(printed):
    """A mass with Dahl friction on a spring, against scipy's solution."""
    m, b, sigma_0, F_c = 5.557, 6.6135, 3.9162e5, 5.999

    def rates(_, state):
        x, v, F = state
        return v, (20.0 - 4e4 * x - b * v - F) / m, sigma_0 * (v - abs(v) * F / F_c)

    run = solve_ivp(rates, (0.0, 0.1), (0.0, 0.0, 0.0), "Radau", rtol=1e-9, atol=1e-12)
    lines = re.findall(r"degree \d: x = (.*) um", printed[-2])
    ends = np.array([[float(x) for x in line.split(", ")] for line in lines])
    errors = abs(ends - 1e6 * run.y[0, -1])
    assert errors.shape == (3, 3)
    assert np.all(errors[:, 1:] < 0.7 * errors[:, :-1])  # halved steps
    assert errors[0, -1] > 10.0 * errors[2, -1]


def test_the_scale_follows_the_friction_of_a_drive_that_gets_warm(printed):
    """ds/dt = rate (1 - 0.3 (1 - exp(-t / 20)) - s), but for the rests between the slides."""
    [scale] = re.findall(r"scale after 60 s: ([\d.]+)", printed[-1])
    rate, T = 0.05, 20.0  # equal time constants
    assert rate * T == 1.0
    expected = 0.7 + 0.3 * (1.0 + 60.0 / T) * np.exp(-60.0 / T)
    assert float(scale) == pytest.approx(expected, abs=0.02)
