"""What a log's owner says of it."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from stickslip.errors import UsageError
from stickslip.fmi.messages import suggestion
from stickslip.logs.controller import Kind, check_gains
from stickslip.logs.products import Product
from stickslip.logs.recording import Motion

ROLES = (
    "time",
    "position",
    "force",
    "velocity",
    "friction",
    "position_command",
    "velocity_command",
    "force_command",
)
"""What a column can be."""
CONFIRMED = ("mass", "speed", "acceleration")
"""What is asked about where no drive is expected to have it."""


def quantity_key(role: str) -> str:
    """Return what a role measures: time, position, velocity or force."""
    return "force" if role == "friction" else role.removesuffix("_command")


@dataclass(frozen=True)
class Column:
    """One column of a log: SI value = unit * scale * logged value + offset.

    Attributes
    ----------
    name : in the header; an integer counts columns from 1; "none" leaves the role empty, None
        looks for a common name
    unit : by name, such as mm or A; None takes it from the header, else SI
    scale : SI units per unit, such as N per A; a product may name scalars of a MAT file; None: 1
    offset : in SI units
    """

    name: str | int | None = None
    unit: str | None = None
    scale: Product | None = None
    offset: Product = 0.0


@dataclass(frozen=True)
class Description:
    """What columns mean, and what else is known; all of it can be left to guesses.

    Attributes
    ----------
    columns : by role, see ``ROLES``
    motion : linear or rotary; None takes it from the units
    controller : kind of the controller in use
    gains : of the controller by name, see ``Controller``; products may name scalars of a MAT file
    encoder_step : resolution of the position [m]; None looks for it
    force_limit : of motor or amplifier [N]
    sample_period : [s]; used instead of the column of time
    span : begin and end of what is used, on the log's own time [s]
    tau_i : time constant of the amplifier's current loop [s]
    confirm : figures that are as extreme as they look: mass, speed, acceleration
    delimiter, decimal : of a text file; None finds out

    Raises
    ------
    UsageError
        When a role or gain is unknown, or a number means nothing.
    """

    columns: Mapping[str, Column] = field(default_factory=dict)
    motion: Motion | None = None
    controller: Kind = "none"
    gains: Mapping[str, Product] = field(default_factory=dict)
    encoder_step: Product | None = None
    force_limit: Product | None = None
    sample_period: float | None = None
    span: tuple[float, float] | None = None
    tau_i: float | None = None
    confirm: tuple[str, ...] = ()
    delimiter: str | None = None
    decimal: str | None = None

    def __post_init__(self) -> None:
        for role in self.columns:
            if role not in ROLES:
                raise UsageError(f"no column has the role '{role}'{suggestion(role, ROLES)}")
        if self.motion not in (None, "linear", "rotary"):
            raise UsageError(f"motion '{self.motion}': expected linear or rotary")
        check_gains(self.controller, self.gains)
        if self.sample_period is not None and not 0 < self.sample_period < math.inf:
            raise UsageError(f"sample_period = {self.sample_period} s: expected more than 0")
        if self.tau_i is not None and not 0 <= self.tau_i < math.inf:
            raise UsageError(f"tau_i = {self.tau_i} s: expected 0 or more")
        if self.span is not None and not self.span[0] < self.span[1]:
            raise UsageError(f"span = {list(self.span)} s: expected begin before end")
        for name in self.confirm:
            if name not in CONFIRMED:
                raise UsageError(f"confirm: no '{name}'{suggestion(name, CONFIRMED)}")
        if self.delimiter is not None and not re.fullmatch(r"[^\w\n\r\"'.+-]", self.delimiter):
            raise UsageError(f"delimiter = '{self.delimiter}': expected one character, such as ;")
        if self.decimal not in (None, ".", ","):
            raise UsageError(f"decimal = '{self.decimal}': expected . or ,")

    def column(self, role: str) -> Column:
        """Return the description of a role's column, which may be empty."""
        return self.columns.get(role, Column())
