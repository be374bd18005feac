"""Uneven times become even without hurting the signals; findings report what was done."""

import numpy as np
import pytest
from rigid_drive import rigid_drive

from stickslip.logs.grid import even_grid
from stickslip.logs.sampling import step_of
from stickslip.logs.table import LogTable

TABLE = LogTable("log", (), {})
DRIVE = rigid_drive(n=3000)
T_S = DRIVE.T_s


def messages(grid) -> str:
    return "\n".join(map(str, grid.findings))


def test_even_times_are_left_alone():
    grid = even_grid(TABLE, DRIVE.t + 7.5, {"position": DRIVE.position})
    assert np.array_equal(grid.signals["position"], DRIVE.position)
    assert not grid.findings
    np.testing.assert_allclose(grid.t, DRIVE.t, atol=1e-12)


@pytest.mark.parametrize("share", [0.05, 0.3])
def test_jitter_is_taken_out(share):
    """A smooth signal is drawn by a cubic: its error falls far below that of the jitter."""
    rng = np.random.default_rng(0)
    t = DRIVE.t + rng.uniform(-share, share, len(DRIVE.t)) * T_S
    x = np.interp(t, DRIVE.t, DRIVE.t)  # the true times, to evaluate the drive at
    x = 0.02 * np.sin(2 * np.pi * (0.4 * x + 0.25 * x**2))
    grid = even_grid(TABLE, t, {"position": x})
    assert "times are uneven" in messages(grid)
    assert "cubic" in messages(grid)
    expected = grid.t + t[0]
    expected = 0.02 * np.sin(2 * np.pi * (0.4 * expected + 0.25 * expected**2))
    assert np.max(np.abs(grid.signals["position"] - expected)) < 2e-9
    assert np.ptp(np.diff(grid.t)) < 1e-12


def test_a_command_with_corners_is_drawn_by_lines():
    rng = np.random.default_rng(1)
    t = np.sort(DRIVE.t + rng.uniform(-0.3, 0.3, len(DRIVE.t)) * T_S)
    corners = np.sign(np.sin(40 * t))
    grid = even_grid(TABLE, t, {"velocity_command": corners})
    assert "velocity_command linear" in messages(grid)
    assert np.abs(grid.signals["velocity_command"]).max() <= 1.0


@pytest.mark.parametrize("n", [1, 5, 6, 100])
def test_short_gaps_are_filled_and_long_ones_cut(n):
    """Rows or numbers: five missing samples in a row are filled in, six split the log."""
    missing = np.arange(1000, 1000 + n)
    rows = np.delete(np.arange(3000), missing)
    force = DRIVE.force.copy()
    force[missing] = np.nan
    used = slice(None) if n <= 5 else slice(1000 + n, None)
    whole = {"position": DRIVE.position, "force": force}
    for t, signals in ((DRIVE.t[rows], {"position": DRIVE.position[rows]}), (DRIVE.t, whole)):
        grid = even_grid(TABLE, t, signals)
        expected = DRIVE.position[used]
        np.testing.assert_allclose(grid.signals["position"], expected, rtol=0, atol=1e-9)
        if t is not DRIVE.t:
            said = f"{n} rows missing" if n <= 5 else f"rows 1001 to {3000 - n}"
            assert said in messages(grid)


def test_numbers_that_are_missing():
    force = DRIVE.force.copy()
    force[[50, 51, 700]] = np.nan, np.inf, np.nan
    force[2000:2050] = np.nan
    grid = even_grid(TABLE, DRIVE.t, {"position": DRIVE.position, "force": force})
    assert len(grid.t) == 2000
    assert np.isfinite(grid.signals["force"]).all()
    np.testing.assert_array_equal(grid.signals["position"], DRIVE.position[:2000])
    assert "force has no numbers in rows 2001 to 2050" in messages(grid)
    assert "3, the first in row 51" in messages(grid)


def test_the_step_of_an_encoder_is_found_and_other_signals_have_none():
    for step, offset in ((4e-7, 0.0), (5e-8, 0.1234), (1e-3, 0.0), (1e-3, 0.1234)):
        x = np.round(DRIVE.position / step) * step + offset
        assert step_of(x) == pytest.approx(step, rel=1e-6)
    assert step_of(DRIVE.position) == 0
    assert step_of(np.random.default_rng(0).standard_normal(5000)) == 0
    assert step_of(np.zeros(100)) == 0
