"""Input clocks of FMI 3.0 and when they tick."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from stickslip.fmi.description.attributes import DescriptionFault, finite, whole

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


def read_clocks(elements: Iterable[Any]) -> tuple[Clock, ...]:
    """Return the input clocks among the elements of variables."""
    clocks = (e for e in elements if e.tag == "Clock" and e.get("causality") == "input")
    return tuple(map(_clock, clocks))


def _clock(element: Any) -> Clock:
    asked = _ASKED.get(element.get("intervalVariability", ""))
    interval = _seconds(element, "interval")
    if asked == _NEVER and not interval:
        asked = _ONCE
    return Clock(
        element.get("name"),
        whole(element.get("valueReference"), "valueReference", element),
        asked,
        interval,
        _seconds(element, "shift"),
    )


def _seconds(element: Any, what: str) -> float:
    """Return a time given as a decimal number or by counter and resolution; 0 where it is not."""
    if decimal := element.get(f"{what}Decimal"):
        seconds = finite(decimal, f"{what}Decimal", element)
    else:
        counter = whole(element.get(f"{what}Counter", "0"), f"{what}Counter", element)
        resolution = whole(element.get("resolution", "1"), "resolution", element)
        if resolution < 1:
            raise DescriptionFault(element, f"resolution is {resolution}, expected at least 1")
        seconds = counter / resolution
    if seconds < 0:
        raise DescriptionFault(element, f"{what} of a clock is {seconds} s, expected none below 0")
    return seconds
