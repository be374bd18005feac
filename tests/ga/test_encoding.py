import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from problems import GENES

from stickslip import ga
from stickslip.ga.problem.problem import Encoding

UNIT = st.lists(st.floats(0, 1), min_size=3, max_size=3).map(lambda row: np.array([row]))


@pytest.mark.parametrize("kind", ["linear", "log"])
@given(strings=UNIT)
def test_decode_undoes_encode_within_the_bounds(kind, strings):
    encoding = Encoding(GENES, kind, None)
    values = encoding.decode(strings)
    assert (values >= encoding.lower).all()
    assert (values <= encoding.upper).all()
    np.testing.assert_allclose(encoding.encode(values), strings, atol=1e-12)


def test_log_gives_each_decade_the_same_room():
    values = Encoding(GENES, "log", None).decode(np.array([[0.0], [1 / 3], [2 / 3], [1.0]]))
    np.testing.assert_allclose(values[:, 0], [0.1, 1, 10, 100])


def test_linear_strings_are_steps_of_the_resolution():
    settled = Encoding(GENES, "linear", 1e-4).settle(np.array([[0.12344, 0.12346, 1.0]]))
    np.testing.assert_allclose(settled, [[0.1234, 0.1235, 1.0]], atol=1e-15)


@given(st.lists(st.floats(-5, 5), min_size=3, max_size=3))
def test_strings_that_left_come_back(row):
    settled = Encoding(GENES, "log", 0.3).settle(np.array([row]))
    assert ((settled >= 0) & (settled <= 1)).all()


def test_strings_are_mirrored_at_their_ends():
    settled = Encoding(GENES, "log", None).settle(np.array([[-0.2, 1.25, 0.5]]))
    np.testing.assert_allclose(settled, [[0.2, 0.75, 0.5]])


def test_log_refuses_a_bound_of_zero():
    with pytest.raises(ga.SettingsError, match="gene x: log encoding needs a lower bound above 0"):
        Encoding([ga.Gene("x", 0.0, 1.0, 0.5)], "log", None)
