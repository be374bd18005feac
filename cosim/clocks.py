"""Input clocks of FMI 3.0 and when they tick."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from lxml import etree

# When an FMU is asked for the interval, by ``intervalVariability``; places in ``enum Asked``.
# Clocks of other kinds are triggered by whoever runs the FMU.
_NEVER, _ONCE = 0, 1
_ASKED = {
    "constant": _NEVER,
    "fixed": _NEVER,
    "tunable": _NEVER,
    "calculated": _ONCE,
    "changing": 2,
    "countdown": 3,
}


@dataclass(frozen=True)
class Clock:
    """An input clock.

    Attributes
    ----------
    asked : when the FMU is asked for the interval, None where the clock does not tick by time
    interval, shift : s
    """

    name: str
    reference: int
    asked: int | None
    interval: float = 0.0
    shift: float = 0.0


def read_clocks(description: Path) -> list[Clock]:
    """Return the input clocks of a model description.

    Raises
    ------
    ValueError
        When a number in it is none.
    """
    elements = etree.parse(description).iterfind(".//ModelVariables/Clock[@causality='input']")
    return [_clock(element) for element in elements]


def _clock(element: etree._Element) -> Clock:
    asked = _ASKED.get(element.get("intervalVariability", ""))
    interval = _seconds(element, "interval")
    if asked == _NEVER and not interval:
        asked = _ONCE
    return Clock(
        element.get("name", ""),
        int(element.get("valueReference", "")),
        asked,
        interval,
        _seconds(element, "shift"),
    )


def _seconds(element: etree._Element, what: str) -> float:
    """Return a time given as a decimal number or by counter and resolution; 0 where it is not."""
    if decimal := element.get(f"{what}Decimal"):
        return float(decimal)
    return int(element.get(f"{what}Counter", "0")) / int(element.get("resolution", "1"))
