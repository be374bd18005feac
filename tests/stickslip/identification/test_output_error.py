from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from stickslip.identification.criteria.known_loop import KnownLoop, OutputError, predictor_error
from stickslip.identification.fitting.bootstrap import correct
from stickslip.identification.fitting.fit import linearised
from stickslip.thresholds import loop_fit
from stickslip.trial.compensator_trial import shown_gains

pytestmark = pytest.mark.slow


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


@pytest.mark.parametrize("off", [0.0, 0.2])
def test_a_bad_fit_does_not_pass_for_noise(off, recorded, candidates):
    """Replicas are given as much noise as the fit left, so they leave as much themselves."""
    learned = recorded.learned.estimation
    best = learned.fit
    q = best.q.copy()
    q[best.space.index("F_c")] += off
    with OutputError(candidates, learned.recording, learned.gains) as criterion:
        criterion.whiten(best.parameters)
        values = best.space.decode(q)
        variance = float(np.var(criterion.residual(values)))
        bad = linearised(criterion.over(best.space), q, variance)
        with KnownLoop(candidates, learned.recording, learned.gains, encoder=True) as again:
            told = correct(criterion, bad, again, 0)
    assert told.found / told.expected < loop_fit.MODEL_ERROR
    assert (told.model_error > loop_fit.MODEL_ERROR) == (off > 0.0)


def test_a_recording_shows_the_gains_of_its_controller(recorded):
    learned = recorded.learned.estimation
    K_p, K_i = shown_gains(learned.recording)
    assert K_p == pytest.approx(learned.gains["K_p"], rel=0.1)
    assert K_i == pytest.approx(learned.gains["K_i"], rel=0.1)
    noise = np.random.default_rng(0).normal(size=len(learned.recording.t))
    assert shown_gains(replace(learned.recording, force=noise)) is None
    assert shown_gains(replace(learned.recording, velocity_command=None)) is None
