"""What aborts a motion, looked at sample by sample."""

import math
from collections import deque
from dataclasses import dataclass

from stickslip.errors import UsageError

SPEED_OVER = 5e-3  # time over which the measured speed is a mean, for the encoder's steps [s]


@dataclass(frozen=True)
class RigLimits:
    """What aborts a motion; all are to be given, infinity for what is not to be watched.

    Attributes
    ----------
    travel : lowest and highest position, from where motions begin [m]; leave room to stop
    speed : [m/s]
    force : of the motor [N]
    following_error : between the position and the integral of the velocity command [m]

    Raises
    ------
    UsageError
        When a limit is not a positive number, or the travel does not contain 0.
    """

    travel: tuple[float, float]
    speed: float
    force: float
    following_error: float

    def __post_init__(self) -> None:
        try:
            for name in ("speed", "force", "following_error"):
                if not getattr(self, name) > 0.0:
                    raise UsageError(f"{name} = {getattr(self, name)}: expected more than 0")
            low, high = self.travel
            around = low < 0.0 < high
        except (TypeError, ValueError) as fault:
            if isinstance(fault, UsageError):
                raise
            raise UsageError(f"{self}: expected numbers, and two of them as travel") from None
        if not around:
            raise UsageError(f"travel = {self.travel}: expected a range around 0")


class Watch:
    """Compares the samples of a motion with limits, while it runs or afterwards."""

    def __init__(self, limits: RigLimits, T_s: float) -> None:
        self.limits, self.T_s = limits, T_s
        self.span = max(1, round(SPEED_OVER / T_s))  # samples
        self._last: deque[float] = deque(maxlen=1 + self.span)
        self._commanded: float | None = None

    def exceeded(self, what: str, value: float) -> str:
        """Return which limit a value exceeds [m, m/s, N, m], or an empty text."""
        if what == "position":
            low, high = self.limits.travel
            within, expected = low <= value <= high, f"{low:g} to {high:g} m"
            return "" if within else f"position {value:.6g} m; expected {expected}"
        most, unit = getattr(self.limits, what), {"speed": "m/s", "force": "N"}.get(what, "m")
        if abs(value) <= most:
            return ""
        name = what.replace("_", " ")
        return f"{name} {abs(value):.4g} {unit}; expected at most {most:g} {unit}"

    def sample(self, x: float, F: float, v_cmd: float | None) -> str:
        """Take the next sample; return which limit it exceeds, or an empty text.

        The position x [m] counts from where motions begin, F is the force [N], and the velocity
        v_cmd [m/s] holds from this sample on; it is None without a velocity loop.
        """
        if not (math.isfinite(x) and math.isfinite(F)):
            return f"position {x} m and force {F} N; expected finite values"
        self._last.append(x)
        full = len(self._last) == self._last.maxlen
        v = (x - self._last[0]) / (self.T_s * (len(self._last) - 1)) if full else 0.0
        signals = [("position", x), ("speed", v), ("force", F)]
        if v_cmd is not None:
            self._commanded = x if self._commanded is None else self._commanded
            signals.append(("following_error", self._commanded - x))
            self._commanded += self.T_s * v_cmd
        return next(filter(None, (self.exceeded(*one) for one in signals)), "")
