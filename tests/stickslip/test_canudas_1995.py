"""Canudas de Wit et al. 1995: numbers of the figures, computed apart from this project by Radau."""

from __future__ import annotations

import numpy as np
import pytest

from stickslip.cli import main
from stickslip.papers.lugre import canudas_1995 as published
from stickslip.papers.lugre.phenomena import contact_of


@pytest.fixture(scope="module")
def contact():
    with contact_of("lugre", **published.PARAMETERS) as contact:
        yield contact


def test_figure_2_displacement_at_the_corners_of_the_force(contact):
    t, force, x = published.presliding(contact)
    corners = [np.searchsorted(t, time - 1e-6) for time in (10, 15, 35, 40, 60, 65)]
    np.testing.assert_allclose(force[corners], 1.425 * np.array([1, 1, -1, -1, 1, 1]))
    expected = (44.86, 45.31, -9.56, -10.02, 44.86, 45.31)
    np.testing.assert_allclose(1e6 * x[corners], expected, atol=0.006)


def test_figure_3_the_loop_widens_with_the_frequency(contact):
    found = [published.lag_width(*published.lag(contact, w)) for w in published.FREQUENCIES]
    assert found == pytest.approx([0.00122, 0.01278, 0.03609], abs=6e-6)


def test_figure_4_break_away_falls_with_the_rate(contact):
    found = [published.break_away(contact, rate) for rate in published.RATES]
    assert found == pytest.approx([1.485, 1.432, 1.394, 1.313, 1.2196, 1.0982, 1.0240], abs=6e-4)


def test_figures_5_and_6_a_spring_that_is_pulled_slips_again_and_again(contact):
    found = published.stick_slip(contact)
    assert published.period(found["time"], found["v"]) == pytest.approx(6.362, abs=3e-3)
    assert found["time"][np.argmax(found["v"] > 0.05)] == pytest.approx(7.55, abs=0.015)
    assert found["v"].max() == pytest.approx(0.370, abs=5e-4)
    assert found["F_f"].max() == pytest.approx(1.477, abs=1e-3)


def test_figures_7_and_8_integral_control_hunts(contact):
    found = published.hunting(contact)
    late = found["time"] > 50.0
    x = found["x"][late] - 1.0
    assert 1e3 * x.max() == pytest.approx(63.9, abs=0.06)
    assert 1e3 * x.min() == pytest.approx(-63.9, abs=0.06)
    assert published.period(found["time"][late], x) == pytest.approx(24.43, abs=0.03)


def test_the_command_draws_them(tmp_path):
    assert main(["phenomena", "--published", str(tmp_path / "figures.png")]) == 0
    assert (tmp_path / "figures.png").read_bytes().startswith(b"\x89PNG")
