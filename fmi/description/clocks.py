"""Input clocks of FMI 3.0 and when they tick."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from stickslip.fmi.description.attributes import DescriptionFault, Remarks, finite, whole

# When an FMU is asked for the interval, by ``intervalVariability``; places in ``enum Asked``.
# Clocks of other kinds are triggered by whoever runs the FMU.
_TRIGGERED = "triggered"
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


def read_clocks(elements: Sequence[Any], remarks: Remarks) -> tuple[Clock, ...]:
    """Return the input clocks among the elements of variables, whose clocks should be some."""
    clocks = [element for element in elements if element.tag == "Clock"]
    references = {element.get("valueReference") for element in clocks}
    for element in elements:
        for word in element.get("clocks", "").split():
            if word not in references:
                remarks.add(element, f"clocks has {word!r:.40}, which is no clock")
    return tuple(_clock(element) for element in clocks if element.get("causality") == "input")


def _clock(element: Any) -> Clock:
    kind = element.get("intervalVariability", _TRIGGERED)
    if kind not in (*_ASKED, _TRIGGERED):
        expected = ", ".join((*_ASKED, _TRIGGERED))
        raise DescriptionFault(element, f"intervalVariability is {kind!r:.40}, expected {expected}")
    asked = _ASKED.get(kind)
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
