"""What the compensator's model does not have: every effect of the drive switched on.

The simulated drive of a reproduction has, but for encoder, force steps and current lag, exactly the
friction that the compensator assumes. ``models/plants/drive/model.toml`` has more.
"""

from __future__ import annotations

from dataclasses import dataclass

import pandas as pd

from stickslip import models
from stickslip.evaluation.validation import Validation


@dataclass(frozen=True)
class Extras:
    """What came out on the drive with all effects on.

    Attributes
    ----------
    validation : None where identification or learning failed
    table4 : with a column for each step
    reason : why they failed
    """

    validation: Validation | None
    table4: pd.DataFrame | None = None
    reason: str = ""


def all_effects() -> dict[str, float]:
    """Return every Boolean parameter of the drive, switched on."""
    variables = models.load_model("drive").variables
    return {v.name: True for v in variables if v.role == "parameter" and v.type == "boolean"}
