"""Which phenomena each friction law shows: statements of the literature, against computed sizes."""

from __future__ import annotations

import textwrap
from pathlib import Path

import numpy as np
import pytest

from stickslip.cli import main
from stickslip.papers.lugre.commands.phenomena import table_of
from stickslip.papers.lugre.phenomena import PHENOMENA, phenomena

STEADY, PRESLIDING, LOSS, LOOP, LAG, SLOW, FAST, DWELL, DRIFT = PHENOMENA


@pytest.fixture(scope="module")
def found():
    return phenomena()


@pytest.fixture(scope="module")
def table(found):
    return found.droplevel(1)


def shown(table, phenomenon, least):
    return {law for law, found in table.items() if abs(found[phenomenon]) > least}


def test_steady_friction_follows_the_stribeck_curve(table):
    drop = 3.0 * (np.exp(-0.2 / 0.55697) - np.exp(-20 / 0.55697))
    # Armstrong: k_t v t = F_c + 3 t / (t + 1) at break-away after t = 79.5 ms at rest
    risen = 3.0 * 0.07945 / 1.07945 / (1.0 + (0.2 / 0.55697) ** 2)
    expected = dict.fromkeys(table, drop) | {"dahl": 0.0, "armstrong": risen}
    for law, found in table.items():
        within = 2e-4 if law == "armstrong" else 1e-4
        assert found[STEADY] == pytest.approx(expected[law], abs=within), law


def test_presliding(table):
    """Coulomb-Stribeck has none; elasto-plastic and Armstrong's have no loss below break-away."""
    every = set(table)
    assert shown(table, PRESLIDING, 0.0) == every - {"coulomb_stribeck"}
    for elastic in ("elasto_plastic", "armstrong"):
        assert table[elastic][PRESLIDING] == pytest.approx(0.5 * 5.999 / 0.39162, rel=1e-3)
    assert shown(table, LOSS, 2e-3) == every - {"elasto_plastic", "armstrong"}
    # Dahl: 4 F_c^2 / sigma_0 (a - tanh a), a = sigma_0 A / F_c
    a = 0.39162 * 10.0 / 5.999
    assert table["dahl"][LOSS] == pytest.approx(4 * 5.999**2 / 0.39162 * (a - np.tanh(a)), rel=1e-4)


def test_minor_loops_close_with_a_memory_that_is_not_local(table):
    assert shown(table, LOOP, 1e-3) == {"dahl", "lugre", "leuven", "elasto_plastic"}
    assert table["leuven"][LOOP] < 0.6 * table["lugre"][LOOP]


def test_friction_lags_behind_the_velocity(table):
    assert shown(table, LAG, 1e-3) == {"lugre", "gms", "leuven", "elasto_plastic", "armstrong"}
    assert table["lugre"][LAG] == pytest.approx(0.187, abs=1e-3)


def test_break_away_falls_with_the_rate_of_the_force(table):
    assert (table["lugre"][SLOW], table["lugre"][FAST]) == pytest.approx((8.155, 6.358), abs=2e-3)
    for law, found in table.items():
        if law in ("lugre", "leuven", "elasto_plastic", "armstrong"):
            assert found[SLOW] > found[FAST] + 1.0, law
    assert table["coulomb_stribeck"][SLOW] == pytest.approx(8.999, abs=2e-3)
    assert table["coulomb_stribeck"][FAST] == pytest.approx(8.999, abs=0.05)
    assert (table["dahl"][SLOW], table["dahl"][FAST]) == pytest.approx((5.999, 5.999), abs=2e-3)
    assert shown(table, DWELL, 1e-3) == {"armstrong"}


def test_an_oscillating_load_moves_some_for_ever(table):
    assert shown(table, DRIFT, 1e-6) == {"dahl", "lugre", "leuven"}
    assert table["lugre"][DRIFT] == pytest.approx(25.56, abs=0.02)


def test_the_page_of_the_documentation_has_the_table(found):
    page = Path(__file__).parents[2] / "docs" / "phenomena.md"
    assert textwrap.indent(table_of(found), "    ") in page.read_text(encoding="utf-8")


def test_the_command_prints_a_column_for_each_law(table, capsys):
    assert main(["phenomena", "lugre", "dahl"]) == 0
    title, *rows = capsys.readouterr().out.splitlines()
    assert title.split() == ["lugre", "dahl"]
    assert len(rows) == len(PHENOMENA)
    for row, name in zip(rows, PHENOMENA, strict=True):
        values = [float(word) for word in row.removeprefix(name).split()[1:]]
        expected = [table[law][name] for law in ("lugre", "dahl")]
        assert values == pytest.approx(expected, rel=1e-3, abs=1e-4)
    assert main(["phenomena", "viscous"]) == 1
    assert "no friction law 'viscous'" in capsys.readouterr().err
