"""Eq. (7) of the paper."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip import ga


def probability(parents, best=4.0, mean=2.0, k1=0.9, k2=0.7):
    return ga.crossover_probability(np.array(parents), best=best, mean=mean, k1=k1, k2=k2)


def test_values_of_equation_7():
    np.testing.assert_allclose(
        probability([4.0, 3.0, 2.5, 2.0, 1.9, 0.0]), [0.0, 0.45, 0.675, 0.9, 0.7, 0.7]
    )


def test_an_equal_generation_crosses_with_k2():
    np.testing.assert_array_equal(probability([2.0, 2.0], best=2.0), [0.7, 0.7])


@given(
    costs=st.lists(st.floats(0, 1e300) | st.just(float("inf")), min_size=4, max_size=12),
    k1=st.floats(0, 1),
    k2=st.floats(0, 1),
)
def test_it_is_a_probability_for_any_generation(costs, k1, k2):
    J = ga.fitness(np.array(costs))
    P_c = ga.crossover_probability(J, best=J.max(), mean=J.mean(), k1=k1, k2=k2)
    assert ((P_c >= 0) & (P_c <= max(k1, k2) * (1 + 1e-9))).all()


@pytest.mark.parametrize(
    ("costs", "expected"),
    [
        ([2.0, 4.0, np.inf], [1, 0.5, 0]),
        ([0.0, 1.0, 0.0], [1, 0, 1]),
        ([np.inf, np.inf], [1, 1]),
    ],
)
def test_fitness_is_the_inverse_of_cost_as_a_fraction_of_the_best(costs, expected):
    np.testing.assert_array_equal(ga.fitness(np.array(costs)), expected)


@given(st.floats(1e-3, 1e3))
def test_scaling_the_cost_leaves_fitness_alone(scale):
    costs = np.array([1.0, 2.0, 5.0])
    np.testing.assert_allclose(ga.fitness(scale * costs), ga.fitness(costs), rtol=1e-12)
