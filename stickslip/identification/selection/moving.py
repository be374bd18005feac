"""The force that a law predicts while the drive moves, beside a regression on the same folds."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from stickslip.catalog.space import Values
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.selection.folds import Fold, is_less, mean_squares
from stickslip.servo.measurement import Array, smoothed


@dataclass(frozen=True)
class Moving:
    """Held-out errors where the drive moves, as root mean squares."""

    law: float  # of the law [N]
    regression: float  # of mass, Coulomb and viscous friction and a constant force [N]
    fails: bool  # whether the regression is the better one, beyond chance

    def scaled(self, factor: float) -> Moving:
        """Return the same in other units."""
        return Moving(factor * self.law, factor * self.regression, self.fails)


def moving(
    inverse: InverseModel, values: Values, residual: Array, split: Iterable[Fold]
) -> Moving | None:
    """Compare a law with a regression of Coulomb and viscous friction where the drive moves.

    Both are fitted to the same samples. At rest a regression does not tell the force, so the errors
    are those where the drive moves. None where it does not.

    Parameters
    ----------
    values : of the law by name, with the delay of the force
    residual : of the law where it was not fitted (k,) [N]
    split : the folds of that residual
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
