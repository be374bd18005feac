"""The tables of several drives, as terminal, page and files have them."""

import math

from stickslip.presentation.quantity import number, symbol
from stickslip.presentation.table import Column, Row

SCALES = {
    ("v_s", "m/s"): (1e3, "mm/s"),
    ("v_s", "rad/s"): (1e3, "mrad/s"),
    ("sigma_0", "N/m"): (1e-6, "N/µm"),
    ("sigma_0", "N.m/rad"): (1e-3, "N m/mrad"),
    ("sigma_1", "N.s/m"): (1e-3, "N s/mm"),
}
"""Factors to units in which numbers are short; other units stay."""


def readable_unit(parameter: str, unit: str) -> tuple[float, str]:
    """Return factor and name of a unit in which the numbers of a parameter are short."""
    return SCALES.get((parameter, unit), (1.0, unit.replace(".", " ")))


def _scaled(row: Row, *names: str) -> str:
    """Return the values of a row that are known, in that unit."""
    factor = readable_unit(row["parameter"], row["unit"])[0]
    known = [row[name] for name in names if row[name] is not None and not math.isnan(row[name])]
    return " to ".join(number(factor * value) for value in known)


def value_column(name: str) -> Column:
    """Return a column of values of parameters."""
    return Column(name, ".5g", name, name, cell=lambda row: _scaled(row, name), words=False)


PARAMETER = Column("parameter", "", "", "parameter", cell=lambda row: symbol(row["parameter"]))
UNIT = Column(
    "unit", "", "", "unit", cell=lambda row: readable_unit(row["parameter"], row["unit"])[1]
)
PARAMETERS = (
    Column("name", head="result"),
    PARAMETER,
    UNIT,
    value_column("value"),
    Column("standard_error"),
    Column("low", head="95 % interval", cell=lambda row: _scaled(row, "low", "high")),
    Column("high"),
    Column("identifiability", head="", cell=lambda row: row["identifiability"] or ""),
)
"""A row for each parameter of each result, in SI units."""
ERRORS = (
    Column("name", "", "", "result"),
    Column("law", "", "law", "law"),
    Column("compensation", "", "compensation", "compensation"),
    Column("share", ".3g", "share", "share"),
    Column("fitted", ".3g", "fitted", "error ratio"),
    Column("worst", ".3g", "worst", "worst"),
)
"""A row for each result: the share that the feedforward gives, and how many times the simulated
tracking error of none is left, as the mean on the fitted drive and at worst on the drives that the
log supports; NaN where it was not tried."""
