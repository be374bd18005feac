import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from problems import GENES

from stickslip import ga

REPAIR = ga.AtLeast("b", "a")


@given(st.tuples(st.floats(0.1, 100), st.floats(0.6, 600), st.floats(1e-5, 1e-2)))
def test_the_constraint_and_the_bounds_hold(row):
    repaired = REPAIR(np.array([row]), GENES)[0]
    assert repaired[1] >= repaired[0]
    for value, gene in zip(repaired, GENES, strict=True):
        assert gene.lower <= value <= gene.upper


def test_a_candidate_that_keeps_the_constraint_is_left_alone():
    values = np.array([[2.0, 3.0, 1e-3], [3.0, 2.0, 1e-3]])
    np.testing.assert_array_equal(REPAIR(values, GENES), [[2.0, 3.0, 1e-3], [2.0, 3.0, 1e-3]])
    assert values[1, 0] == 3.0


def test_a_repair_that_changes_the_shape_is_refused():
    algorithm = ga.GeneticAlgorithm(GENES, repair=lambda values, _: values[0])
    with pytest.raises(ga.SettingsError, match=r"shape \(10, 3\), got \(3,\)"):
        algorithm.ask()


def test_it_pickles():
    assert pickle.loads(pickle.dumps(REPAIR)) == REPAIR  # noqa: S301 - our own bytes


def test_an_unknown_gene_is_named():
    with pytest.raises(ga.SettingsError, match="no gene 'z' among a, b, c"):
        ga.AtLeast("z", "a")(np.ones((1, 3)), GENES)


def test_bounds_without_room_are_refused():
    genes = [ga.Gene("low", 0, 1, 0.5), ga.Gene("high", 2, 3, 2.5)]
    with pytest.raises(ga.SettingsError, match="low ends at 1, below the lower bound 2 of high"):
        ga.AtLeast("low", "high")(np.array([[0.5, 2.5]]), genes)
