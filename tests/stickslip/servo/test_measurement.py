"""The low-pass of measured signals is that of scipy.signal."""

import numpy as np
import pytest
from scipy.signal import butter, lfilter, sosfiltfilt

from stickslip.servo.measurement import filter_by_section, smoothed


@pytest.mark.parametrize("share", [1e-5, 3e-3, 0.1, 0.3, 0.499])  # of the sampling frequency
@pytest.mark.parametrize("shape", [(10,), (4000,), (3, 500)])
def test_a_signal_is_smoothed_as_scipy_does(share, shape):
    T_s = 2.5e-4
    signal = np.cumsum(np.random.default_rng(len(shape)).normal(size=shape), axis=-1)
    kept = signal.copy()
    wanted = sosfiltfilt(butter(2, share / T_s, fs=1 / T_s, output="sos"), signal)
    found = smoothed(signal, T_s, share / T_s)
    np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9 * np.max(np.abs(signal)))
    np.testing.assert_array_equal(signal, kept)


def test_columns_and_few_samples_are_smoothed_and_a_section_begins_at_rest():
    columns = np.random.default_rng(1).normal(size=(200, 3))
    found = smoothed(columns.T, 1e-3, 40.0)
    for k in range(3):
        np.testing.assert_array_equal(found[k], smoothed(columns[:, k], 1e-3, 40.0))
    np.testing.assert_allclose(smoothed(np.full(4, 2.0), 1e-3, 40.0), 2.0)
    signal = np.random.default_rng(2).normal(size=(2, 300))
    wanted = lfilter([0.3], [1.0, -0.7], signal)
    section = np.array([0.3, 0.0, 0.0, 1.0, -0.7, 0.0])
    np.testing.assert_allclose(filter_by_section(section, signal), wanted, rtol=1e-12)


@pytest.mark.parametrize("cutoff", [0.0, 500.0, 600.0])
def test_a_cut_off_beyond_half_the_sampling_frequency_is_refused(cutoff):
    with pytest.raises(ValueError, match="below 500 Hz"):
        smoothed(np.zeros(100), 1e-3, cutoff)
