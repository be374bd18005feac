"""The experiment run again, with the encoder that it had: what the fit gets wrong, and by how much.

In a recording the encoder's steps went around the loop and shook the drive a little, which makes
friction look lower at slow speeds. The fit's own loop is smooth. So recordings are made anew with
the fitted values, with the encoder's steps and as much noise as the residual asks for. The values
are moved until the recording's residual is like those of its replicas, as far as Gauss steps can
tell; the scatter of these steps is the covariance.

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
from stickslip.identification.criteria.known_loop import KnownLoop
from stickslip.identification.criteria.motion import position_noise
from stickslip.identification.criteria.output_error import OutputError
from stickslip.identification.fitting.fit import Fit, linearised
from stickslip.logs import Recording
from stickslip.servo.measurement import Array

RUNS = 30
ROUNDS = 3
NUMERICS = 5e-6
"""Share of the motion by which a simulated loop may be wrong; logs of simulations show it."""


@dataclass(frozen=True)
class Corrected:
    """A fit without its bias.

    Attributes
    ----------
    fit : at the corrected values, with the covariance of the replicas
    bias : (9,) that was taken off the coordinates
    mean : (k,) what replicas leave on average, whitened [m]
    whitening : of the judge
    expected : standard deviation [m] of the residual before whitening, in the worst replica,
        or what a simulation may be wrong by
    found : and in the recording
    noise : standard deviation on the position, beside the encoder's steps [m]
    unexplained : standard deviation of the whitened residual, over that of the position's own
        steps and noise
    """

    fit: Fit
    bias: Array
    mean: Array
    whitening: Array
    expected: float
    found: float
    noise: float
    unexplained: float

    @property
    def model_error(self) -> float:
        """How many times larger the residual is than encoder and noise explain.

        Before whitening it shows what is slow; whitened, what replicas would take for noise.
        """
        return max(self.found / self.expected, self.unexplained)


def correct(
    judge: OutputError,
    fitted: Fit,
    fmus: Path,
    recording: Recording,
    gains: Mapping[str, float],
    seed: int,
) -> Corrected:
    """Take off the bias of a whitened fit, by replicas of the experiment."""
    judge, step = judge.over(fitted.space), recording.encoder_step
    rng = np.random.default_rng(seed)
    noise = float(np.sqrt(max(fitted.variance - step**2 / 12.0, 1e-6 * fitted.variance)))
    at = fitted
    workers = judge.loop.workers
    with KnownLoop(fmus, recording, gains, encoder=True, workers=workers) as loop:
        for _ in range(ROUNDS):
            raws = _replicas(judge, loop, at.parameters, step, noise, rng)
            moves = np.array([at.shift(judge.white(raw)) for raw in raws])
            own = at.step() - moves.mean(axis=0)
            q = judge.space.inside(at.q + own)
            at = linearised(judge, q, fitted.variance)
    spread = np.cov(moves.T) * (1.0 + 1.0 / RUNS)
    own = NUMERICS * float(np.std(judge.position))
    expected = max(own, *(float(np.std(raw[judge.used])) for raw in raws))
    found = float(np.std(judge.raw(at.parameters)[judge.used]))
    mean = judge.white(raws.mean(axis=0))
    corrected = replace(at, covariance=spread)
    bias = fitted.q - at.q
    unexplained = float(np.sqrt(fitted.variance)) / max(own, position_noise(judge.position, step))
    return Corrected(corrected, bias, mean, judge.whitening, expected, found, noise, unexplained)


def _replicas(
    judge: OutputError,
    loop: KnownLoop,
    values: Values,
    step: float,
    noise: float,
    rng: np.random.Generator,
) -> Array:
    """Return what the smooth loop leaves of recordings made anew (RUNS, n) [m]."""
    smooth = judge.loop.run(values)["candidate.x"]

    def left(drawn: tuple[float, int]) -> Array:
        offset, seed = drawn
        further = {
            "candidate.noise_x": noise,
            "candidate.seed": seed,
            "candidate.x": smooth[0] + offset,
        }
        return np.asarray(loop.run(values, further)["candidate.x_enc"] - offset - smooth)

    drawn = [(step * rng.random(), int(rng.integers(2**31))) for _ in range(RUNS)]
    return np.array(loop.each(left, drawn))
