"""The roles of a log's columns: from its description, or detected from common names."""

from __future__ import annotations

import re

from stickslip.errors import RecordingError
from stickslip.logs.description import ROLES, Description, quantity_key
from stickslip.logs.finding import Finding
from stickslip.logs.table import LogTable
from stickslip.logs.units import QUANTITIES, unit_named

_EXACT = {
    "time": "t time timestamp",
    "position": "x q y qm pos position x_enc x_m x_meas q_m q_meas x_act q_act theta phi angle",
    "velocity": "v dq dx vel velocity speed omega w v_m v_meas v_act qd_meas qdot xdot dqm dqdt",
    "force": "f tau f_m f_meas tau_m tau_meas force torque motor_force motor_torque",
    "friction": "friction f_f friction_force friction_torque tau_f",
    "position_command": "qg ref reference setpoint x_cmd x_ref x_d q_cmd q_ref q_d r theta_ref",
    "velocity_command": "v_cmd v_ref v_d dq_ref dq_cmd omega_ref omega_cmd",
    "force_command": "f_cmd f_ref tau_cmd tau_ref u_cmd",
}
_WEAK = {
    "force": "u i iq i_q vir current motor_current strom motorstrom courant corrente corriente",
    "time": "index",
}
_BASES = {
    "time": "time seconds zeit temps tempo tiempo",
    "position": "position pos angle displacement encoder enc theta travel lage winkel posizione",
    "velocity": "velocity vel speed omega geschwindigkeit drehzahl vitesse velocità velocidad",
    "force": "force torque tau current thrust kraft moment drehmoment strom courant corrente",
    "friction": "friction",
}
_COMMANDS = "cmd command commanded ref reference setpoint set target desired demand soll sollwert"
_OTHERS = "error err deviation limit max min std normal status mode raw ff feedforward acc load"
"""Words of what is none of our signals."""


_NAMED = (
    ("percentage", r"%|‰|percent|prozent|per_?mil|promille|(^|_)(pct|rated)(_|$)"),
    ("current", r"current|strom|courant|corr[ie]+nte|amp[eèé]r|(^|_)(i|iq|i_q|amps)(_|$)"),
    ("voltage", r"voltage|spannung|(^|_)(u|vir|volts?)(_|$)"),
    ("number", r"(^|_)(index|counts?|cts|inc|increments|ticks|pulses|samples?)(_|$)"),
    ("torque", r"torque|(moment|coppia|(^|_)couple)(_|$)"),
    ("angle", r"(^|_)(angle|theta|phi|\w*winkel)(_|$)"),
)
"""What a column's name says that it measures; the first that fits."""


_MEASURED = {"time": "time"} | {
    quantity: role for motion in QUANTITIES.values() for role, quantity in motion.items()
}
"""What a column is whose unit measures this."""


def assign_roles(table: LogTable, description: Description) -> tuple[dict[str, str], list[Finding]]:
    """Return column names by role, and remarks on what was detected.

    Raises
    ------
    RecordingError
        When a named column is missing, one has two roles, or a guess is not clear.
    """
    found: dict[str, str] = {}
    for role, column in description.columns.items():
        if column.name in (None, "none"):
            continue
        name = table.find(column.name if column.name is not None else "", role)
        if name in found.values():
            other = next(key for key, value in found.items() if value == name)
            raise RecordingError(f"{table.path}: column '{name}' cannot be {other} and {role}")
        found[role] = name
    if not table.headed:
        return found, []
    open_roles = [role for role in ROLES if description.column(role).name is None]
    guesses = _guesses(table, open_roles, set(found.values()))
    if not guesses:
        return found, []
    figure = ", ".join(f"{role} = {name}" for role, name in guesses.items())
    advice = "--column ROLE=NAME overrides one, --column ROLE=none omits it"
    remarks = [Finding("note", "columns detected by their names", figure, advice)]
    used = {*found.values(), *guesses.values()}
    if rest := [name for name in table.names if name not in used]:
        shown = ", ".join(rest[:8]) + (", ..." if len(rest) > 8 else "")
        remarks.append(Finding("note", "columns not used", shown))
    return found | guesses, remarks


def _guesses(table: LogTable, roles: list[str], taken: set[str]) -> dict[str, str]:
    candidates: dict[str, dict[int, list[str]]] = {}
    for name in table.names:
        if name in taken or (name not in table.numbers and not _may_be_time(table, name)):
            continue
        if found := _role_of(name, table.units.get(name)):
            role, rank = found
            candidates.setdefault(role, {}).setdefault(rank, []).append(name)
    guesses = {}
    for role in roles:
        if role not in candidates:
            continue
        best = candidates[role][min(candidates[role])]
        if len(best) > 1:
            several = " or ".join(f"{role}={name}" for name in best)
            raise RecordingError(
                f"{table.path}: which column is {role}? give --column {several}, or {role}=none"
            )
        guesses[role] = best[0]
    return guesses


def _may_be_time(table: LogTable, name: str) -> bool:
    return name in table.texts and (role_named(name) or ("", 0))[0] == "time"


def _role_of(name: str, stated: str | None) -> tuple[str, int] | None:
    """Return role and rank (0 is best) of a column, by its name and the unit that it states."""
    found = role_named(name)
    unit = unit_named(stated) if stated else None
    measured = _MEASURED.get(unit.quantity) if unit else None
    if measured is None:
        return found
    if found is None:
        commanded = set(_words(name)) & set(_COMMANDS.split()) and measured != "time"
        return (f"{measured}_command", 1) if commanded else None
    role, rank = found
    if quantity_key(role) == measured:
        return found
    return (f"{measured}_command", rank) if role.endswith("_command") else None


def role_named(name: str) -> tuple[str, int] | None:
    """Return role and rank of a column's name, None when it says nothing."""
    words = _words(name)
    joined = "_".join(words)
    for rank, table in ((0, _EXACT), (2, _WEAK)):
        for role, names in table.items():
            if joined in names.split():
                return role, rank
    if not set(words) & set(_OTHERS.split()):
        bases = {role for role, names in _BASES.items() if set(words) & set(names.split())}
        base = "friction" if "friction" in bases else next(iter(sorted(bases)), None)
        if base and (len(bases) == 1 or base == "friction"):
            commanded = bool(set(words) & set(_COMMANDS.split())) and base in (
                "position",
                "velocity",
                "force",
            )
            return (f"{base}_command" if commanded else base), 1
    return None


def _words(name: str) -> list[str]:
    """Return the words of the last component of a name, in small letters, without a unit."""
    last = re.sub(r"^.*[.:/](?=[^\W\d_])", "", _split_suffix(name)[0])
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", last)
    return [word.lower() for word in re.split(r"[\W_]+", spaced) if word]


def named_quantity(name: str) -> str | None:
    """Return what a column's name says that it measures: current, torque and so on, else None."""
    plain = "_".join(_words(name)) + "".join(re.findall("[%‰]", name))
    return next((quantity for quantity, pattern in _NAMED if re.search(pattern, plain)), None)


def suffix_unit(name: str) -> str | None:
    """Return what may be a unit at the end of a name such as ``force_N`` or ``v_mm_s``."""
    return _split_suffix(name)[1]


_PER_TIME = re.compile(r"(.+)[_ ](m|cm|mm|um|nm|in|inch|rad|mrad|deg|rev)[_/](s|min)")
_SUFFIXES = (
    "s ms us ns mm cm um nm inch rad mrad deg rev n mn kn nm mnm knm ncm a ma arms v rpm mmps mps "
    "counts cts inc ticks samples pct percent permille"
)


def _split_suffix(name: str) -> tuple[str, str | None]:
    """Return a name without its unit, and the unit; the index of a symbol is none."""
    if match := _PER_TIME.fullmatch(name):
        return match[1], f"{match[2]}/{match[3]}"
    head, _, tail = name.replace(" ", "_").rpartition("_")
    index = len(head) <= 1 and tail in ("s", "N", "A", "V") and head.lower() not in ("t", "f", "i")
    one = len(tail) == 1 and tail not in ("s", "N", "A", "V")
    if not head or tail.lower() not in _SUFFIXES.split() or index or one:
        return name, None
    return head, tail
