"""Numbers that may be products of numbers and of names from the log: ``2*kv*gtau``."""

from __future__ import annotations

import math
from collections.abc import Mapping

from stickslip.errors import UsageError
from stickslip.fmi.messages import suggestion

Product = float | str
"""A number, or factors joined by ``*``, each a number or a name."""


def value_of(product: Product, names: Mapping[str, float], what: str) -> float:
    """Return the value of a product.

    Parameters
    ----------
    product : to work out
    names : the scalars that the log's file holds
    what : name of the value, for the message

    Raises
    ------
    UsageError
        When a factor is neither number nor name, or the value is not finite.
    """
    value = 1.0
    for factor in str(product).split("*"):
        name = factor.strip()
        try:
            value *= names[name] if name in names else float(name)
        except ValueError:
            raise UsageError(
                f"{what} = {product}: '{name}' is no number and no scalar of the file"
                f"{suggestion(name, names)}"
            ) from None
    if not math.isfinite(value):
        raise UsageError(f"{what} = {product}: expected a finite number, got {value}")
    return value
