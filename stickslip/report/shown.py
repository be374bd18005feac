"""Figures and quantities as the page shows them."""

from __future__ import annotations

from stickslip.catalog.parameters import UNITS
from stickslip.identification.stages import Estimate
from stickslip.report.markup import (
    Html,
    element,
    symbol,
    text,
)
from stickslip.report.picture import Picture
from stickslip.report.quantity import (
    SCALES,
    SYMBOLS,
    number,
    unit,
    with_error,
)
from stickslip.report.style import COLUMN

METRICS = {"E_max": symbol("E", "max"), "E_rms": symbol("E", "rms")}


def figure(picture: Picture, alternative: str, caption: str) -> Html:
    """Return a picture on its white card with a caption.

    Parameters
    ----------
    alternative : what a reader who does not see the picture is told
    """
    image = Html(f'<img src="{picture.embedded()}" alt="{text(alternative)}">')
    kind = "column" if picture.width <= COLUMN else "page"
    card = element(
        "div", image, class_="scroll", tabindex="0", role="region", aria_label=alternative
    )
    return element("figure", card, element("figcaption", caption), class_=kind)


def parameter(name: str) -> Html:
    """Return the symbol of a parameter of Table 2."""
    return symbol(*SYMBOLS[name])


def parameter_unit(name: str) -> str:
    """Return the unit in which the page shows a parameter of Table 2."""
    return SCALES[name][1] if name in SCALES else unit(UNITS[name])


def parameter_value(name: str, value: float, digits: int = 5) -> str:
    """Return a value, given in SI, in that unit."""
    return number(value * _scale(name), digits)


def parameter_estimate(name: str, estimate: Estimate) -> str:
    """Return an estimate, given in SI, in that unit, with its standard error."""
    scale = _scale(name)
    return with_error(estimate.value * scale, estimate.standard_error * scale)


def _scale(name: str) -> float:
    return SCALES[name][0] if name in SCALES else 1.0
