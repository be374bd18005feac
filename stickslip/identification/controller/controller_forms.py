"""Other discretisations of the controller, expressed in gains of the controller FMU.

The FMU adds an error to its integral before it uses that, and its low-pass is exact for a held
input. Controllers that use the integral first, or the mean of both, are the same with less
proportional gain; those whose low-pass is a difference quotient, with another time constant.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

OWN = ""  # name of the form that the FMU has
_INTEGRALS = {"": 0.0, "integral by the trapezoidal rule": 0.5, "integral by forward Euler": 1.0}
"""Share of the last sample's error that the integral in use lacks."""
_FILTERS = ("", "low-pass by backward Euler", "low-pass by forward Euler")


def forms(gains: Mapping[str, float], T_s: float) -> dict[str, dict[str, float]]:
    """Return gains of the FMU for each form that a controller may have, by a name for people.

    Parameters
    ----------
    gains : as they were given, in any units that agree
    T_s : sample period of the log [s], if the gains have none
    """
    T_s = gains.get("T_s", T_s)
    found: dict[str, dict[str, float]] = {}
    for integral, lacking in _INTEGRALS.items():
        for low_pass in _FILTERS:
            form = {
                **gains,
                "K_p": gains.get("K_p", 0.0) - lacking * T_s * gains.get("K_i", 0.0),
                "P_x": gains.get("P_x", 0.0) - lacking * T_s * gains.get("I_x", 0.0),
                "tau_f": _time_constant(low_pass, gains.get("tau_f", 0.0), T_s),
            }
            if min(form["K_p"], form["P_x"]) >= 0.0 and form not in found.values():
                found[", ".join(filter(None, (integral, low_pass)))] = form
    return found


def _time_constant(low_pass: str, tau_f: float, T_s: float) -> float:
    """Return tau_f [s] of the exact low-pass that weighs its input as a difference quotient does.

    The FMU weighs it by 1 - e^(-T_s / tau_f), backward Euler by T_s / (T_s + tau_f), forward Euler
    by T_s / tau_f.
    """
    if "backward" in low_pass and tau_f > 0.0:
        return T_s / math.log1p(T_s / tau_f)
    if "forward" in low_pass and tau_f > T_s:
        return -T_s / math.log1p(-T_s / tau_f)
    return tau_f
