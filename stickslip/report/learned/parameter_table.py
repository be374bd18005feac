"""parameters.csv: what was learned, how well it is known, in SI units."""

from __future__ import annotations

import pandas as pd

from stickslip.catalog.parameters import unit_of
from stickslip.identification.estimation import Estimation


def parameter_table(estimation: Estimation) -> pd.DataFrame:
    """Return a row for each parameter.

    Returns
    -------
    DataFrame
        parameter, unit, value, standard_error, low, high (95 %), visible, sentence
    """
    rotary = estimation.recording.motion == "rotary"
    rows = [
        {
            "parameter": name,
            "unit": unit_of(name, rotary=rotary),
            "value": known.value,
            "standard_error": known.standard_error,
            "low": known.low,
            "high": known.high,
            "visible": known.visible,
            "sentence": known.sentence,
        }
        for name, known in estimation.known.items()
    ]
    return pd.DataFrame(rows)
