"""How much of what a search saw of the cost comes from each gene."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pandas as pd

CLASSES = 8  # of a gene's values, with as many candidates each


def importances(history: pd.DataFrame, names: Sequence[str]) -> dict[str, float]:
    """Return the share of the variance of the cost's rank that each gene explains alone.

    It is the correlation ratio over classes of the gene's values, less what classes of a gene
    without influence would explain. Ranks do not depend on the scale of the cost, and candidates
    that failed rank last. The candidates are those of the search, not a random sample: genes that
    moved together share their influence.

    Parameters
    ----------
    history : a row for each candidate, as ``Optimiser.history``
    names : of the genes

    Returns
    -------
    gene -> 0 (no influence is seen) to 1 (it alone decides), the largest first

    Source
    ------
    K. Pearson, On the general theory of skew correlation and non-linear regression, 1905.
    """
    rank = history["cost"].rank()
    n, count = len(rank), min(CLASSES, max(len(rank) // 2, 1))
    total = float(((rank - rank.mean()) ** 2).sum())
    found = {}
    for name in names:
        classes = (history[name].rank() - 1.0) * count // n
        within = float(((rank - rank.groupby(classes).transform("mean")) ** 2).sum())
        free = n - classes.nunique()
        share = 1.0 - (within / free) / (total / (n - 1)) if total and free > 0 else 0.0
        found[name] = float(np.clip(share, 0.0, 1.0))
    return dict(sorted(found.items(), key=lambda one: -one[1]))
