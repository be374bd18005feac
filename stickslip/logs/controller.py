"""The controller with which a log was recorded."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, fields
from typing import Literal, get_args

from stickslip.errors import UsageError
from stickslip.fmi.messages import suggestion

Kind = Literal["P", "PI", "PID", "cascade", "P-PI", "P-P", "none"]

_TAKES: dict[str, tuple[tuple[set[str], set[str]], ...]] = {
    "P": (({"P_x"}, set()), ({"K_p"}, set())),
    "PI": (({"P_x", "I_x"}, set()), ({"K_p", "K_i"}, set())),
    "PID": (({"P_x", "I_x", "K_p"}, set()),),
    "cascade": (({"K_x", "K_p"}, {"K_i", "velocity_feedforward"}),),
    "P-PI": (({"K_x", "K_p", "K_i"}, {"velocity_feedforward"}),),
    "P-P": (({"K_x", "K_p"}, {"velocity_feedforward"}),),
    "none": ((set(), set()),),
}
"""Per kind: alternatives of the gains that it needs and those that it may have."""
COMMON = frozenset({"tau_f", "T_s", "u_max"})  # what any controller may have


@dataclass(frozen=True)
class Controller:
    """A controller of position and velocity, in SI units.

    With e_x = x_cmd - x and e_v = velocity_feedforward v_cmd + K_x e_x - v_est::

        u = P_x e_x + I_x integral(e_x) + K_p e_v + K_i integral(e_v),  |u| <= u_max

    A command that was not logged is 0. P and PI act on position (P_x, I_x) or on velocity (K_p,
    K_i); PID acts on position, with K_p for the derivative; a cascade, P-PI or
    P-P, has K_x around K_p, K_i.
    """

    kind: Kind = "none"  # P, PI, PID, cascade, P-PI, P-P or none (unknown)
    K_x: float = 0.0  # [1/s]
    # share of v_cmd that a cascade follows [1]; None: 1 where a velocity command was logged, else 0
    velocity_feedforward: float | None = None
    P_x: float = 0.0  # [N/m]
    I_x: float = 0.0  # [N/(m s)]
    K_p: float = 0.0  # [N s/m]
    K_i: float = 0.0  # [N/m]
    # time constant of the low-pass behind v_est, which differentiates the position [s]
    tau_f: float = 0.0
    T_s: float = 0.0  # its sample period [s]; 0: that of the log
    u_max: float = math.inf  # [N]

    @property
    def needs(self) -> str | None:
        """The role of the command that it needs; None for an unknown controller."""
        if self.kind == "none":
            return None
        return "position_command" if self.K_x or self.P_x or self.I_x else "velocity_command"

    def parameters(self) -> dict[str, float] | None:
        """Return the parameters of the controller FMU, None if unknown; T_s and u_max if known."""
        if self.kind == "none":
            return None
        given = {name: getattr(self, name) for name in GAINS}
        values = {name: float(value) for name, value in given.items() if value is not None}
        if not self.T_s:
            del values["T_s"]
        if math.isinf(self.u_max):
            del values["u_max"]
        return values


GAINS = tuple(field.name for field in fields(Controller) if field.name != "kind")
"""Names that a gain can have."""


def check_gains(kind: str, gains: Collection[str]) -> None:
    """Check that a kind of controller has exactly these gains.

    Raises UsageError when the kind or a gain is unknown, or one is missing or superfluous.
    """
    if kind not in get_args(Kind):
        raise UsageError(f"controller '{kind}': expected one of {', '.join(get_args(Kind))}")
    for name in gains:
        if name not in GAINS:
            raise UsageError(f"controller: no gain '{name}'{suggestion(name, GAINS)}")
    if kind == "none" and gains:
        kinds = ", ".join(get_args(Kind)[:-1])
        raise UsageError(
            f"gain {sorted(gains)[0]}, but no controller; choose one with --controller: {kinds}"
        )
    given = set(gains) - COMMON
    if not any(needed <= given <= needed | optional for needed, optional in _TAKES[kind]):
        expected = " or ".join(
            " and ".join(sorted(needed)) + "".join(f" (and {name})" for name in sorted(optional))
            for needed, optional in _TAKES[kind]
        )
        got = ", ".join(sorted(given)) or "none"
        raise UsageError(f"controller {kind}: expected gains {expected}, got {got}")
