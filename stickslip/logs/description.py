"""The description of a log and its controller: given in Python, in a TOML file, or by options."""

import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, ClassVar, Literal, get_args

from stickslip.errors import UsageError
from stickslip.fmi.messages import suggestion
from stickslip.logs.recording import Motion
from stickslip.logs.units import expected_units, unit_named
from stickslip.toml_files import NUMBER, TABLE, TEXT, checked, is_number, list_of, read_toml
from stickslip.toml_files import Kind as KeyKind

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
    tau_f: float = 0.0  # time constant of the low-pass behind v_est, a derivative [s]
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
    """Raise UsageError unless a kind of controller is known and has exactly these gains."""
    if kind not in get_args(Kind):
        raise UsageError(f"controller '{kind}': expected one of {', '.join(get_args(Kind))}")
    for name in gains:
        if name not in GAINS:
            raise UsageError(f"controller: no gain '{name}'{suggestion(name, GAINS)}")
    if kind == "none" and gains:
        kinds = ", ".join(get_args(Kind)[:-1])
        raise UsageError(
            f"gain {sorted(gains)[0]}, but no controller; choose one with <controller>: {kinds}"
        )
    given = set(gains) - COMMON
    if not any(needed <= given <= needed | optional for needed, optional in _TAKES[kind]):
        expected = " or ".join(
            " and ".join(sorted(needed)) + "".join(f" (and {name})" for name in sorted(optional))
            for needed, optional in _TAKES[kind]
        )
        got = ", ".join(sorted(given)) or "none"
        raise UsageError(f"controller {kind}: expected gains {expected}, got {got}")


Product = float | str
"""A number, or factors joined by ``*``, each a number or the name of a scalar in the log's file."""

ROLES = (
    "time", "position", "force", "velocity", "friction", "position_command", "velocity_command",
    "force_command", "added_force", "added_velocity",
)  # fmt: skip
"""What a column can be."""
CONFIRMED = ("mass", "speed", "acceleration", "force")
"""Figures that are errors where they are extreme, until they are confirmed."""


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
    """What columns mean, and what else is known; what is left out is detected.

    Attributes
    ----------
    columns : by role, see ``ROLES``
    motion : linear or rotary; None takes it from the units
    controller : kind of the controller in use
    gains : of the controller by name, see ``Controller``; products may name scalars of a MAT file
    encoder_step : resolution of the position [m]; None looks for it
    force_limit : of motor or amplifier [N]
    rated_force, rated_torque : what 100 % of a rated force, torque or current stand for [N], [N m]
    sample_period : [s]; used instead of the column of time
    span : begin and end of what is used, on the log's own time [s]
    tau_i : time constant of the amplifier's current loop [s]
    confirm : figures that are as extreme as they look: mass, speed, acceleration, force
    delimiter, decimal : of a text file; None detects it

    Raises
    ------
    UsageError
        When a role or gain is unknown, or a number is out of range.
    """

    ROLES: ClassVar = ROLES
    CONTROLLERS: ClassVar = get_args(Kind)
    GAINS: ClassVar = GAINS

    columns: Mapping[str, Column] = field(default_factory=dict)
    motion: Motion | None = None
    controller: Kind = "none"
    gains: Mapping[str, Product] = field(default_factory=dict)
    encoder_step: Product | None = None
    force_limit: Product | None = None
    rated_force: Product | None = None
    rated_torque: Product | None = None
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
        for role, column in self.columns.items():
            if not isinstance(column, Column):
                raise UsageError(f"columns: {role}: expected a Column, got {column!r:.80}")
            if column.unit is not None and unit_named(column.unit) is None:
                raise UsageError(
                    f"unit '{column.unit}' of {role} is unknown; expected {expected_units(role)}"
                )
        for name in ("sample_period", "tau_i"):
            if not isinstance(value := getattr(self, name), int | float | None):
                raise UsageError(f"{name} = {value!r:.80}: expected a number, in s")
        if self.span is not None and not (len(self.span) == 2 and all(map(is_number, self.span))):
            raise UsageError(f"span = {self.span!r:.80}: expected begin and end, in s")
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

    @property
    def rated(self) -> Product | None:
        """What 100 % of a force or torque stand for."""
        return self.rated_force if self.rated_torque is None else self.rated_torque

    def column(self, role: str) -> Column:
        """Return the description of a role's column, which may be empty."""
        return self.columns.get(role, Column())


PRODUCT: KeyKind = (lambda value: is_number(value) or isinstance(value, str), "a number or product")
_KEYS: dict[str, KeyKind] = {
    **dict.fromkeys(("columns", "controller"), TABLE),
    **dict.fromkeys(("motion", "delimiter", "decimal"), TEXT),
    **dict.fromkeys(("encoder_step", "force_limit", "rated_force", "rated_torque"), PRODUCT),
    **dict.fromkeys(("sample_period", "tau_i"), NUMBER),
    "span": (lambda value: list_of(value, is_number) and len(value) == 2, "[begin, end] in s"),
    "confirm": (lambda value: list_of(value, TEXT[0]), "a list of texts"),
}
_COLUMN_KEYS: dict[str, KeyKind] = {
    **dict.fromkeys(("name", "unit"), TEXT),
    **dict.fromkeys(("scale", "offset"), PRODUCT),
    "index": (lambda value: type(value) is int and value > 0, "a number from 1"),
}


def load_description(path: Path) -> Description:
    """Read a description.

    The file holds the fields of ``Description`` by name; ``[columns.ROLE]`` the fields of
    ``Column``, or in short ``columns.ROLE = "NAME"``, with ``index`` for a number from 1;
    ``[controller]`` ``kind`` and the gains. Raises UsageError when it cannot be read, or a key or
    value is not valid.
    """
    content = read_toml(path)
    try:
        given = checked(content, _KEYS)
        columns = given.pop("columns", {}).items()
        given["columns"] = {role: _column(role, column) for role, column in columns}
        if "controller" in given:
            kinds = {"kind": TEXT, **dict.fromkeys(GAINS, PRODUCT)}
            given["gains"] = checked({"kind": "", **given["controller"]}, kinds, "controller.")
            given["controller"] = given["gains"].pop("kind")
        return Description(**given)
    except UsageError as error:
        raise UsageError(f"{path}: {error}") from None


def _column(role: str, value: Any) -> Column:
    if isinstance(value, str | int):
        value = {"name" if isinstance(value, str) else "index": value}
    given = checked({role: value}, {role: TABLE}, "columns.")[role]
    given = checked(given, _COLUMN_KEYS, f"columns.{role}.")
    if "name" in given and "index" in given:
        raise UsageError(f"columns.{role}: expected name or index, got both")
    if "index" in given:
        given["name"] = given.pop("index")
    return Column(**given)
