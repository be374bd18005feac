"""Results as what other libraries label with units: xarray and Pint, which are optional."""

from __future__ import annotations

import re
from importlib import import_module
from math import isclose
from typing import TYPE_CHECKING, Any

from stickslip.cosim.errors import CosimError
from stickslip.fmi.description.units import BASE_UNITS, Unit
from stickslip.fmi.messages import shown

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

_EXPONENT = re.compile(r"(?<=[A-Za-z])(-?\d+)")
_OTHER_NAMES = {"Nm": "N*m", "Ohm": "ohm"}  # Pint takes Nm for a number of metres
_OTHER_NAME = re.compile(r"\b(Nm|Ohm)\b")


def to_xarray(frame: pd.DataFrame) -> xr.Dataset:
    """Return a data set along the index; ``frame.attrs["units"]`` are attributes of its variables.

    Raises
    ------
    CosimError
        When xarray is not installed.
    """
    _library("xarray", "xarray")
    data: xr.Dataset = frame.to_xarray()
    for name, unit in {frame.index.name: "s", **frame.attrs["units"]}.items():
        if unit:
            data[name].attrs["units"] = unit
    return data


def with_pint(frame: pd.DataFrame, units: dict[str, Unit | None]) -> pd.DataFrame:
    """Return a frame with columns of Pint, dimensionless where a signal has no unit.

    Raises
    ------
    CosimError
        When pint-pandas is not installed, or Pint does not know a unit that its FMU does not
        define either.
    """
    pint = _library("pint", "pint-pandas")
    _library("pint_pandas", "pint-pandas")
    registry = pint.get_application_registry()
    kinds = {
        str(name): f"pint[{_pint_unit(registry, str(name), unit):~}]" if unit else "pint[]"
        for name, unit in units.items()
    }
    return frame.astype(kinds)


def _pint_unit(registry: Any, name: str, unit: Unit) -> Any:
    """Return a unit by its name where Pint means the same by it, else by its definition."""
    base, offset = None, 0.0 if unit.relative else unit.offset
    if unit.exponents is not None:
        powers = zip(BASE_UNITS, unit.exponents, strict=True)
        base = registry.parse_units(" * ".join(f"{one}**{power}" for one, power in powers))
    try:
        text = _OTHER_NAME.sub(lambda found: _OTHER_NAMES[found[0]], unit.name.replace(".", "*"))
        found = registry.parse_units(_EXPONENT.sub(r"**\1", text))
        if base is None:
            return found
        zero, one = (registry.Quantity(x, found).to(base).magnitude for x in (0.0, 1.0))
        if isclose(zero, offset, abs_tol=1e-12) and isclose(one, unit.factor + offset):
            return found
    except (ValueError, TypeError, AttributeError):  # Pint's own are of these kinds
        pass
    if base is None or unit.factor != 1.0 or offset:
        raise CosimError(
            f"{name}: Pint knows no unit {shown(unit.name)}; define it in Pint's registry"
            " (pint.get_application_registry().define), or take the frame without Pint"
        )
    return base


def _library(module: str, package: str) -> Any:
    try:
        return import_module(module)
    except ImportError:
        raise CosimError(f"{package} is needed: pip install 'stickslip[units]'") from None
