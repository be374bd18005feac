"""Numbers as people read them: rounded, thousands set apart, with symbols and units."""

import math
from collections.abc import Callable, Mapping
from typing import Any

from markupsafe import Markup

from stickslip.catalog.parameters import HIGH, LOW, Estimate, parameter
from stickslip.models import Law

SPACE = "\u00a0"  # Does not break

METRICS = {"E_max": "$E_{max}$", "E_rms": "$E_{rms}$"}
"""Symbols of the errors (8a) and (8b), for pages and figures."""

_RANGED = Markup('{}<span class="range">{}</span>')
_SHOWN = {"m/s": (1e3, "mm/s")}
"""Units that read better than the SI unit of a parameter: factor and name."""


def symbol(name: str) -> str:
    """Return the symbol of a parameter, for pages and figures."""
    return parameter(name).symbol


def meaning(name: str, law: Law | None = None) -> str:
    """Return what a parameter is in a friction law, in the first law that has it by default."""
    found = law.parameters.get(name) if law else None
    return (found or parameter(name)).description


def parameter_unit(name: str) -> str:
    """Return the unit in which the pages show a parameter of a linear drive."""
    given = parameter(name).unit
    return _SHOWN[given][1] if given in _SHOWN else unit(given)


def parameter_value(name: str, value: float) -> str:
    """Return a value, given in SI, in that unit."""
    return number(value * _factor(name), 5)


def parameter_estimate(name: str, estimate: Estimate) -> str:
    """Return an estimate, given in SI, in that unit, with its standard error."""
    return with_error(estimate.value * _factor(name), estimate.standard_error * _factor(name))


def _factor(name: str) -> float:
    return _SHOWN.get(parameter(name).unit, (1.0, ""))[0]


def size_or_dash(value: float) -> str:
    """Return a number, or a dash where a run has failed."""
    return f"{value:.3g}" if math.isfinite(value) else "-"


def number(value: float, digits: int = 4) -> str:
    """Return a number to so many significant digits, e.g. ``0.5``, ``4697``, ``68 310``.

    Trailing zeros are dropped. Very large and very small ones get a power of ten.
    """
    if not math.isfinite(value):
        return "–"
    if value == 0.0:
        return "0"
    if exponent := _exponent(value):
        mantissa = number(round(value / 10.0**exponent, digits - 1), digits)
        return f"{mantissa}{_power(exponent)}"
    text = _fixed(value, digits - 1 - math.floor(math.log10(abs(value))))
    return text.rstrip("0").rstrip(".") if "." in text else text


def percent(share: float, digits: int = 1) -> str:
    """Return a share as per cent, e.g. ``95.7 %``."""
    return f"{_fixed(100.0 * share, digits)}{SPACE}%" if math.isfinite(share) else "–"


def ranged(
    row: Mapping[Any, float], name: str, show: Callable[[float], str] = "{:.3f}".format
) -> str:
    """Return the median of a row and below it, where it has one, its range."""
    ends = [show(row[end]) for end in (f"{name}{LOW}", f"{name}{HIGH}") if end in row]
    spread = "–".join(ends).replace(f"{SPACE}%–", "–")
    return _RANGED.format(show(row[name]), spread) if ends else show(row[name])


def percentage(share: float) -> str:
    """Return a share as per cent, to three significant digits, e.g. ``0.0171 %``."""
    return f"{number(100.0 * share, 3)}{SPACE}%"


def with_error(value: float, error: float) -> str:
    """Return a value and its standard error, both to the error's second digit."""
    if not (math.isfinite(error) and error > 0.0):
        return number(value)
    exponent = _exponent(max(abs(value), error))
    value, error = value / 10.0**exponent, error / 10.0**exponent
    decimals = 1 - math.floor(math.log10(error))
    text = f"{_fixed(value, decimals)}{SPACE}±{SPACE}{_fixed(error, decimals)}"
    return f"({text}){_power(exponent)}" if exponent else text


def interval(low: float, high: float) -> str:
    """Return both ends of an interval, e.g. ``5.9969 … 6.0000``.

    Both to the second digit of its half-width, or to three digits where it spans a factor of 10.
    """
    if not (0.0 < high - low < math.inf):
        return "–"
    if low > 0.0 and high > 10.0 * low:
        return f"{number(low, 3)} … {number(high, 3)}"
    exponent = _exponent(max(abs(low), abs(high)))
    low, high = low / 10.0**exponent, high / 10.0**exponent
    decimals = 1 - math.floor(math.log10(0.5 * (high - low)))
    ends = f"{_fixed(low, decimals)} … {_fixed(high, decimals)}"
    return f"({ends}){_power(exponent)}" if exponent else ends


def unit(text: str) -> str:
    """Return a unit of the FMUs (``N.s/m``, ``kg.m2``) as it is printed (``N s/m``, ``kg m²``)."""
    return "" if text == "1" else text.replace(".", "\u00a0").replace("m2", "m²")


def _fixed(value: float, decimals: int) -> str:
    """Return a number to a decimal place (tens and hundreds too), thousands set apart."""
    text = f"{round(value, decimals):.{max(decimals, 0)}f}".replace("-", "−")
    whole, point, rest = text.partition(".")
    if len(whole.lstrip("−")) > 4:
        whole = f"{int(whole.replace('−', '-')):,}".replace(",", SPACE).replace("-", "−")
    return whole + point + rest


def _exponent(value: float) -> int:
    """Return the power of ten to write apart: 0 but for very large and very small values."""
    if value == 0.0 or not math.isfinite(value):
        return 0
    exponent = math.floor(math.log10(abs(value)))
    return 0 if -4 <= exponent <= 6 else exponent


def _power(exponent: int) -> str:
    superscript = str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"{SPACE}×{SPACE}10{superscript}"
