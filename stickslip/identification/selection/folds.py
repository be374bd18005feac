"""The error that noise or a regression makes in the parts of a recording that are held out."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from stickslip.catalog.parameters import Values
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.known_loop import KnownLoop
from stickslip.identification.criteria.motion import position_noise, position_of
from stickslip.identification.fitting.bootstrap import resimulated, surrogate_loop
from stickslip.identification.held_out import BLOCKS, Fold, is_less, mean_squares
from stickslip.servo.measurement import Array, smoothed


def explained(inverse: InverseModel, residual: Array, encoder: Array) -> float:
    """Return it as a root mean square [N].

    In blocks of the recording the residual may have more at high frequencies, where a model's error
    is small, than the encoder makes: the median excess is noise of the force. The residual (k,) [N]
    is what a fit leaves of the force, and ``encoder`` what ``encoder_error`` returns for it.
    """
    white = np.random.default_rng(1).standard_normal(len(inverse.t))
    white = smoothed(white, inverse.T_s, inverse.cutoff)
    excess, unit = (
        float(np.median(blocks))
        for blocks in (_fast(residual, inverse) - _fast(encoder, inverse), _fast(white, inverse))
    )
    of_force = max(excess, 0.0) / unit * float(np.mean(white**2))
    return float(np.sqrt(np.mean(encoder**2) + of_force))


def encoder_error(
    inverse: InverseModel, values: Values, gains: Mapping[str, float] | None = None
) -> Array:
    """Return the error of the inverse model (k,) [N] in a recording of exactly this drive.

    The drive is simulated along the recording, with the encoder's steps and noise, and the force
    that its values predict is compared with its own. Where the gains of the controller are known,
    its loop is simulated beside one with a surrogate that follows the motion: a loop with wrong
    values may oscillate, and the smaller error is returned.
    """
    if inverse.measures_friction:
        return np.zeros_like(inverse.t[inverse.used])
    step = inverse.recording.encoder_step
    shown = position_noise(position_of(inverse.recording), step)
    noise = float(np.sqrt(max(shown**2 - step**2 / 12.0, 0.0)))
    offset = step * float(np.random.default_rng(0).random())
    errors = []
    with surrogate_loop(inverse, values) as loop:
        errors += resimulated(inverse, loop, values, [offset], noise=noise)
    if gains is not None:
        with KnownLoop(inverse.fmus, inverse.recording, gains, encoder=True) as loop:
            errors += resimulated(inverse, loop, values, [offset], noise=noise)
    least = min(errors, key=lambda error: float(np.mean(error**2)))
    if np.mean(least**2) > np.mean(inverse.force[inverse.used] ** 2):  # no such drive moves so
        return np.zeros_like(least)
    return least


def _fast(signal: Array, inverse: InverseModel) -> Array:
    """Return the mean square of what is above half the cut-off in each block."""
    fast = signal - smoothed(signal, inverse.T_s, 0.5 * inverse.cutoff)
    return np.array([np.mean(block**2) for block in np.array_split(fast, BLOCKS)])


@dataclass(frozen=True)
class Moving:
    """Held-out errors where the drive moves, as root mean squares."""

    law: float  # of the law [N]
    regression: float  # of mass, Coulomb and viscous friction and a constant force [N]
    fails: bool  # whether the regression is the better one, beyond chance

    def scaled(self, factor: float) -> "Moving":
        """Return the same in other units."""
        return Moving(factor * self.law, factor * self.regression, self.fails)


def moving(
    inverse: InverseModel, values: Values, residual: Array, split: Iterable[Fold]
) -> Moving | None:
    """Compare a law with a regression of Coulomb and viscous friction where the drive moves, if so.

    Both are fitted to the same samples of the folds: the values give the delay of the force, the
    residual (k,) [N] is that of the law where it was not fitted. At rest a regression does not
    tell the force.
    """
    moves = inverse.moves[inverse.used]
    if not moves.any():
        return None
    sign = smoothed(np.sign(inverse.motion.v), inverse.T_s, inverse.cutoff)
    rigid = inverse.linear[:, 2 if inverse.measures_friction else 0 :]
    x = np.column_stack([sign, rigid])[inverse.used]
    y, rest = inverse.measured(values)[inverse.used], np.empty_like(residual)
    for fold in split:
        fitted = np.linalg.lstsq(x[fold.fitted], y[fold.fitted])[0]
        rest[fold.held_out] = (y - x @ fitted)[fold.held_out]
    law, regression = (mean_squares(one, moves) for one in (residual, rest))
    sizes = [float(np.sqrt(np.mean(one[moves] ** 2))) for one in (residual, rest)]
    return Moving(sizes[0], sizes[1], is_less(regression, law))
