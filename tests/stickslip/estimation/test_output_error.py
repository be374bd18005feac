import numpy as np
import pytest
from scipy.signal import lfilter

from stickslip.estimation.output_error import predictor_error


@pytest.mark.parametrize("pole", [0.9, -0.5])
def test_the_whitening_of_an_autoregression_is_its_polynomial(pole):
    noise = np.random.default_rng(0).standard_normal(200_000)
    signal = lfilter([1.0], [1.0, -pole], noise)
    taps = predictor_error(signal, 5)
    np.testing.assert_allclose(taps, [1.0, -pole, 0, 0, 0, 0], atol=0.02)
    white = lfilter(taps, [1.0], signal)
    assert abs(np.corrcoef(white[1:], white[:-1])[0, 1]) < 0.01


def test_a_signal_of_zeros_stays():
    assert predictor_error(np.zeros(100), 5).tolist() == [1.0]
