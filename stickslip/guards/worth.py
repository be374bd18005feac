"""The refusal: a compensator must not make the loop worse."""

from __future__ import annotations

from stickslip.errors import HarmfulError
from stickslip.guards.trial import Trial


def refuse_worse(trial: Trial) -> tuple[float, float]:
    """Return the RMS tracking error without and with the compensator [m/s].

    Raises
    ------
    HarmfulError
        When it is larger with the compensator than without.
    """
    without, compensated = trial.errors()
    if not compensated < without:
        raise HarmfulError(
            f"with the compensator the simulated tracking error is {1e3 * compensated:.3g} mm/s;"
            f" expected less than without it, {1e3 * without:.3g} mm/s; raise K_p (now"
            f" {trial.loop.K_p:.4g} N s/m), learn anew, or compensate faster commands only"
        )
    return without, compensated
