"""Numbers as people read them: rounded, thousands set apart, with symbols and units."""

from __future__ import annotations

import math

SPACE = "\u00a0"
"""Does not break."""

SCALES = {"v_s": (1e3, "mm/s")}
"""Parameters that read better in another unit than SI: factor and unit."""

SYMBOLS = {
    "m": ("m", ""),
    "b": ("b", ""),
    "F_s": ("F", "s"),
    "F_c": ("F", "c"),
    "v_s": ("v", "s"),
    "sigma_0": ("σ", "0"),
    "sigma_1": ("σ", "1"),
}
MEANINGS = {
    "m": "inertia",
    "b": "viscous friction",
    "F_s": "stick force",
    "F_c": "Coulomb friction",
    "v_s": "Stribeck velocity",
    "sigma_0": "bristle stiffness",
    "sigma_1": "bristle damping",
}


def number(value: float, digits: int = 4) -> str:
    """Return a number to so many significant digits, e.g. ``0.5``, ``4697``, ``68 310``.

    Trailing zeros are dropped. Very large and very small ones get a power of ten.
    """
    if not math.isfinite(value):
        return "–"
    if value == 0.0:
        return "0"
    exponent = math.floor(math.log10(abs(value)))
    if not -4 <= exponent <= 6:
        mantissa = number(round(value / 10.0**exponent, digits - 1), digits)
        return f"{mantissa}{SPACE}×{SPACE}10{_superscript(exponent)}"
    decimals = digits - 1 - exponent
    text = _fixed(value, decimals)
    return text.rstrip("0").rstrip(".") if "." in text else text


def percent(share: float, digits: int = 1) -> str:
    """Return a share as per cent, e.g. ``95.7 %``."""
    return f"{_fixed(100.0 * share, digits)}{SPACE}%"


def with_error(value: float, error: float) -> str:
    """Return a value and its standard error, both to the error's second digit."""
    if not (math.isfinite(error) and error > 0.0):
        return number(value)
    decimals = 1 - math.floor(math.log10(error))
    return f"{_fixed(value, decimals)}{SPACE}±{SPACE}{_fixed(error, decimals)}"


def unit(text: str) -> str:
    """Return a unit of the FMUs (``N.s/m``) as it is printed (``N s/m``)."""
    return "" if text == "1" else text.replace(".", "\u00a0")


def _fixed(value: float, decimals: int) -> str:
    """Return a number to a decimal place (tens and hundreds too), thousands set apart."""
    text = f"{round(value, decimals):.{max(decimals, 0)}f}".replace("-", "−")
    whole, point, rest = text.partition(".")
    if len(whole.lstrip("−")) > 4:
        whole = f"{int(whole.replace('−', '-')):,}".replace(",", SPACE).replace("-", "−")
    return whole + point + rest


def _superscript(exponent: int) -> str:
    return str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
