"""Parametric bootstrap of the output error: the bias of the fit, and its covariance.

In a recording, encoder quantisation passes through the loop and excites the drive a little, so that
friction looks lower at slow speeds. The loop that the fit simulates is smooth. So recordings are
simulated with the fitted values, with the encoder's steps and the noise of the residual. Gauss
steps move the values until the residual of the recording is like those of the bootstrap samples;
the scatter of these steps is the covariance.

The bootstrap's model is the law. Mass, viscous friction and offset have true values beside the law,
so their standard errors are those from blocks of the residual where these are larger.

Source
------
Gourieroux, Monfort, Renault, J. Applied Econometrics 8 (1993) S85 (indirect inference).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stickslip.catalog.space import Values
from stickslip.identification.criteria.closing import Closing
from stickslip.identification.criteria.known_loop import KnownLoop
from stickslip.identification.criteria.motion import position_noise
from stickslip.identification.criteria.output_error import OutputError
from stickslip.identification.fitting.fit import Fit, linearised
from stickslip.logs import Recording
from stickslip.progress import steps
from stickslip.servo.measurement import Array

RUNS = 30
FEW = (10, 10)  # bootstrap samples of the rounds before the last, which only bring the values near
NUMERICS = 5e-6  # numerical error of a simulated loop, as share of the motion


@dataclass(frozen=True)
class UnbiasedFit:
    """A fit without its bias."""

    fit: Fit  # at the corrected values, with the covariance of the bootstrap
    bias: Array  # (k,) that was subtracted from the coordinates
    mean: Array  # (n,) mean residual of the bootstrap samples, whitened [m]
    whitening: Array  # of the criterion
    # largest standard deviation [m] of the residual before whitening in a bootstrap sample, or the
    # numerical error of a simulation
    expected: float
    found: float  # the same of the recording
    noise: float  # standard deviation on the position, beside the encoder's steps [m]
    # standard deviation of the whitened residual, over that of the position's own steps and noise
    unexplained: float

    @property
    def model_error(self) -> float:
        """Ratio of the residual to that from encoder and noise, the larger of two.

        Before whitening it shows slow errors; whitened, those that the bootstrap takes for noise.
        """
        return max(self.found / self.expected, self.unexplained)


class Resimulation(Closing):
    """Simulates a recording again with any values, encoder steps and noise included.

    Parameters
    ----------
    criterion : gives the recorded commands' loop, and the number of parallel runs
    """

    def __init__(
        self, criterion: OutputError, fmus: Path, recording: Recording, gains: Mapping[str, float]
    ) -> None:
        self.step = recording.encoder_step
        self._smooth = criterion.loop
        workers = self._smooth.workers
        self._loop = KnownLoop(fmus, recording, gains, encoder=True, workers=workers)

    def residuals(
        self, values: Values, noise: float, rng: np.random.Generator, count: int
    ) -> Array:
        """Return the residuals (count, n) [m] that values leave of recordings of themselves."""
        smooth = self._smooth.run(values)["candidate.x"]

        def left(drawn: tuple[float, int]) -> Array:
            offset, seed = drawn
            further = {
                "candidate.noise_x": noise,
                "candidate.seed": seed,
                "candidate.x": smooth[0] + offset,
            }
            return np.asarray(self._loop.run(values, further)["candidate.x_enc"] - offset - smooth)

        drawn = [(self.step * rng.random(), int(rng.integers(2**31))) for _ in range(count)]
        return np.array(self._loop.each(left, drawn))

    def close(self) -> None:
        """Free the FMUs."""
        self._loop.close()


def correct(criterion: OutputError, fitted: Fit, again: Resimulation, seed: int) -> UnbiasedFit:
    """Subtract the bias of a whitened fit by a parametric bootstrap of the experiment."""
    criterion, step = criterion.over(fitted.space), again.step
    rng = np.random.default_rng(seed)
    noise = float(np.sqrt(max(fitted.variance - step**2 / 12.0, 1e-6 * fitted.variance)))
    at = fitted
    for runs in steps((*FEW, RUNS)):
        raws = again.residuals(at.parameters, noise, rng, runs)
        moves = np.array([at.shift(criterion.white(raw)) for raw in raws])
        q = criterion.space.inside(at.q + at.step() - moves.mean(axis=0))
        at = replace(at, q=q, residual=criterion.residual(criterion.space.decode(q)))
    at = linearised(criterion, at.q, fitted.variance)
    spread = np.cov(moves.T) * (1.0 + 1.0 / RUNS)
    wider = _wider(fitted, spread)
    spread *= np.outer(wider, wider)
    own = NUMERICS * float(np.std(criterion.position))
    expected = max(own, *(float(np.std(raw[criterion.used])) for raw in raws))
    found = float(np.std(criterion.raw(at.parameters)[criterion.used]))
    mean = criterion.white(raws.mean(axis=0))
    corrected = replace(at, covariance=spread)
    bias = fitted.q - at.q
    unexplained = float(np.sqrt(fitted.variance)) / max(
        own, position_noise(criterion.position, step)
    )
    return UnbiasedFit(
        corrected,
        bias,
        mean,
        criterion.whitening,
        expected=expected,
        found=found,
        noise=noise,
        unexplained=unexplained,
    )


def _wider(fitted: Fit, spread: Array) -> Array:
    """Return factors (k,) of the bootstrap's standard errors of what is not the law's own."""
    alone = np.maximum(np.diag(spread), np.finfo(float).tiny)
    wider = np.sqrt(np.maximum(np.diag(fitted.covariance) / alone, 1.0))
    return np.where(
        [name in fitted.space.law.parameters for name in fitted.space.names], 1.0, wider
    )
