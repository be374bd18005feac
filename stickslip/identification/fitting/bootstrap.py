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

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stickslip.catalog.parameters import Values
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.known_loop import HELD, KnownLoop, OutputError, Point
from stickslip.identification.criteria.motion import position_of
from stickslip.identification.fitting.fit import Fit, linearised
from stickslip.logs import Recording
from stickslip.output import steps
from stickslip.servo.measurement import Array, derivative, smoothed
from stickslip.thresholds import loop_fit

BIAS_RUNS = 8
ROUNDS = 3
BANDWIDTH = 0.02  # bandwidth of the surrogate's velocity loop, as a share of the sample rate
LOOSE = 0.5  # standard error of a coordinate above which it is not corrected


def coarse(inverse: InverseModel, recording: Recording) -> bool:
    """Return whether encoder quantisation is coarse enough to require a correction.

    Where it is not, the bootstrap samples differ mainly by the surrogate controller, and a
    correction made the result for a measured axis (EMPS) worse.
    """
    top = float(np.quantile(np.abs(inverse.motion.v), 0.99))
    return recording.encoder_step / recording.T_s > loop_fit.COARSE * top


def correct_inverse(inverse: InverseModel, fitted: Fit, seed: int) -> tuple[Fit, Array, bool]:
    """Return the fit without its bias, and the bias (k,) that was subtracted from its coordinates.

    Encoder quantisation, the low-pass and sampling bias the fit of the inverse model. A simulated
    drive with the fitted values follows the recorded motion under a surrogate controller, is
    recorded with the same encoder, and is fitted by one Gauss step; the difference from the known
    values is subtracted.

    The last value is whether the residuals of bootstrap samples are about as large as those of the
    recording. If not, the surrogate excites the drive differently from its real controller, and
    the bias is not valid.
    """
    space = fitted.space
    rng = np.random.default_rng(seed)
    at, ratios = fitted, []
    loose = np.sqrt(np.diag(fitted.covariance)) > LOOSE
    with surrogate_loop(inverse, fitted.parameters) as loop:
        for _ in range(ROUNDS):
            drawn = inverse.recording.encoder_step * rng.random(BIAS_RUNS)
            left = resimulated(inverse, loop, at.parameters, drawn.tolist())
            ratios.append(float(np.mean(np.square(left))) / at.variance)
            own = at.step() - np.mean([at.shift(one) for one in left], axis=0)
            q = at.q + np.where(loose, 0.0, own)
            q = space.inside(q)
            at = linearised(inverse.over(space), q, fitted.noise)
    return replace(at, covariance=fitted.covariance), fitted.q - at.q, is_alike(ratios[0])


def is_alike(ratio: float) -> bool:
    """Tell whether a ratio of mean squares, resimulated to recorded, is that of a like loop."""
    return 1.0 / loop_fit.ALIKE < ratio < loop_fit.ALIKE


def surrogate_loop(inverse: InverseModel, values: Values) -> KnownLoop:
    """Return a loop in which the drive with these values follows the recorded motion."""
    recording = inverse.recording
    path, T_s = smoothed(position_of(recording), recording.T_s, inverse.cutoff), recording.T_s
    led = replace(recording, position_command=path, velocity_command=derivative(path, T_s))
    # The motion shows what was added; without its known force the loop begins balanced.
    led = replace(led, added_force=None, added_velocity=None, known_force=None)
    led = replace(led, friction_factor=None)
    # A cascade for the fitted mass, whose integral starts at the constant force.
    rate = 2.0 * np.pi * BANDWIDTH / T_s  # [rad/s]
    K_p = rate * values["m"]
    gains = {"K_p": K_p, "K_i": K_p * rate / 8.0, "K_x": rate / 4.0, "tau_f": T_s, "T_s": T_s}
    gains[HELD] = values["F_0"]
    return KnownLoop(inverse.fmus, led, gains, encoder=True, workers=inverse.runs.workers)


def resimulated(
    inverse: InverseModel,
    loop: KnownLoop,
    values: Values,
    offsets: Sequence[float],
    noise: float = 0.0,
) -> list[Array]:
    """Return residuals (k,) [N] of the drive with these values, simulated and recorded again.

    For each, the drive, and so the encoder's steps, are displaced by an offset [m]; the position
    has white noise of this standard deviation [m].
    """
    recording = inverse.recording
    law, q = inverse.space.law, inverse.q
    runs = loop.results(
        [
            Point(
                {**values, "delay": 0.0},
                {"candidate.noise_x": max(noise, 1e-9 * abs(offset))},
                offset=offset,
            )
            for offset in offsets
        ]
    )
    # The drive's output at the end of a sample is the force held over it; the controller adds the
    # constant force, so the output contains it.
    late = recording.t + values["delay"] + 0.5 * recording.T_s
    residuals = []
    for run in runs:
        again = replace(
            recording,
            position=run["candidate.x_enc"],
            force=np.interp(late, recording.t, run["candidate.F_m"]) + values["F_0"],
            known_force=None,  # the drive had none
            friction_factor=None,
        )
        with InverseModel(inverse.fmus, again, inverse.cutoff, law=law, q=q) as copy:
            residuals.append(copy.residual(values))
    return residuals


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
    unexplained: float  # deviation of the whitened residual, over that of steps and noise

    @property
    def model_error(self) -> float:
        """Ratio of the residual to that from encoder and noise, as it is or whitened."""
        return max(self.found / self.expected, self.unexplained)


def resimulated_residuals(
    criterion: OutputError,
    again: KnownLoop,  # the loop of the criterion, with the encoder
    values: Values,
    count: int,
    noise: float,  # on the position [m]
    rng: np.random.Generator,
) -> Array:
    """Return the residuals (count, n) [m] that values leave of recordings of themselves."""
    smooth = criterion.loop.run(values)["candidate.x"]
    drawn = [(criterion.step * rng.random(), int(rng.integers(2**31))) for _ in range(count)]
    runs = [
        Point(values, {"candidate.noise_x": noise, "candidate.seed": seed}, offset=offset)
        for offset, seed in drawn
    ]
    both = zip(again.results(runs), drawn, strict=True)
    return np.array([run["candidate.x_enc"] - offset - smooth for run, (offset, _) in both])


def correct(criterion: OutputError, fitted: Fit, again: KnownLoop, seed: int) -> UnbiasedFit:
    """Subtract the bias of a fit by a bootstrap; ``again`` is its loop with the encoder."""
    criterion, step = criterion.over(fitted.space), criterion.step
    rng = np.random.default_rng(seed)
    noise = float(np.sqrt(max(fitted.variance - step**2 / 12.0, 1e-6 * fitted.variance)))
    at = fitted
    for runs in steps((*FEW, RUNS)):
        raws = resimulated_residuals(criterion, again, at.parameters, runs, noise=noise, rng=rng)
        moves = np.array([at.shift(criterion.white(raw)) for raw in raws])
        q = criterion.space.inside(at.q + at.step() - moves.mean(axis=0))
        at = replace(at, q=q, residual=criterion.residual(criterion.space.decode(q)))
    at = linearised(criterion, at.q, fitted.variance)
    spread = np.cov(moves.T) * (1.0 + 1.0 / RUNS)
    alone = np.maximum(np.diag(spread), np.finfo(float).tiny)
    wider = np.sqrt(np.maximum(np.diag(fitted.covariance) / alone, 1.0))
    wider[[name in fitted.space.law.parameters for name in fitted.space.names]] = 1.0
    spread *= np.outer(wider, wider)
    own = NUMERICS * float(np.std(criterion.position))
    return UnbiasedFit(
        fit=replace(at, covariance=spread),
        bias=fitted.q - at.q,
        mean=criterion.white(raws.mean(axis=0)),
        whitening=criterion.whitening,
        expected=max(own, *(float(np.std(raw[criterion.used])) for raw in raws)),
        found=float(np.std(criterion.raw(at.parameters)[criterion.used])),
        unexplained=float(np.sqrt(fitted.variance)) / max(own, criterion.noise),
    )
