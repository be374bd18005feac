"""The roles of a log's columns: from its description, or detected from common names."""

from __future__ import annotations

import re

from stickslip.errors import RecordingError
from stickslip.logs.description import ROLES, Description
from stickslip.logs.finding import Finding
from stickslip.logs.table import LogTable
from stickslip.logs.units import QUANTITIES, quantity_key, unit_named

_EXACT = {
    "time": "t time timestamp zeitstempel time_stamp x_value",
    "position": "x q y qm pos position x_enc x_m q_m theta phi angle",
    "velocity": "v dq dx vel velocity speed omega w v_m xdot qdot dqm dqdt",
    "force": "f tau f_m tau_m force torque motor_force motor_torque",
    "friction": "friction f_f friction_force friction_torque tau_f",
    "position_command": "qg ref reference setpoint x_d q_d r",
    "velocity_command": "v_d",
}
_WEAK = {
    "force": "u i iq i_q vir motor_current motorstrom corriente",
    "time": "index date datum date_time datetime",
}
_SYMBOLS = {
    "position": "x q s y pos phi theta",
    "velocity": "v n w vel omega qd dq dx",
    "force": "f m tau",
}
"""Symbols of a signal where a word beside them tells whether it is actual or commanded."""
_ACTUAL = "act actual ist istwert meas measured fb feedback"
_FILLERS = "value wert val smoothed filtered geglättet glatt co"
"""Words that change nothing."""
_BASES = {
    "time": "time seconds zeit uhrzeit temps tempo tiempo",
    "position": "position pos angle displacement encoder enc theta travel lage winkel weg "
    "posizione",
    "velocity": "velocity vel velo speed omega geschwindigkeit drehzahl vitesse velocità velocidad",
    "force": "force torque tau thrust kraft moment drehmoment trq",
    "current": "current strom courant corrente",
    "friction": "friction reibung",
}
_COMMANDS = "cmd command commanded ref reference setpoint set target desired demand soll sollwert"
_OTHERS = (
    "error err deviation limit max min std normal status mode raw ff feedforward acc load lag diff "
    "difference following abweichung regelabweichung grenze grenzwert temperature temperatur "
    "vorsteuerung fehler schleppfehler schleppabstand offset last power leistung"
)
"""Words of what is none of our signals."""
_ADDED = "added additive injected injection dither pulse pulses excitation anregung aufschaltung"
_FEEDFORWARD = "ff feedforward vorsteuerung"
"""Words of a signal that is added to what the controller commands, or to its velocity command."""
_NUMBERED = {
    **dict.fromkeys(("r61", "r63", "606c"), "velocity"),
    **dict.fromkeys(("r60", "r62", "60ff"), "velocity_command"),
    **dict.fromkeys(("r80", "6077"), "force"),
    **dict.fromkeys(("r79", "6071"), "force_command"),
    **dict.fromkeys(("r2521", "6064"), "position"),
    **dict.fromkeys(("r2556", "607a"), "position_command"),
    **dict.fromkeys(("r78", "6078"), "force"),
    "60b2": "added_force",
    "60b1": "added_velocity",
}
"""Roles of parameters of SINAMICS and of objects of CiA 402."""
_CURRENTS = ("r78", "6078")
_COMPOUND = re.compile(
    r"(ist|soll)?(motor|antriebs|achs)?"
    r"(lage|position|weg|winkel|geschwindigkeit|drehzahl|kraft|moment|drehmoment|strom)s?(en)?"
    r"(ist|soll)?(wert)?"
)
"""A German compound, such as Drehmomentistwert or Istlage."""


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
        best = _distinct(table, candidates[role][min(candidates[role])])
        if len(best) > 1:
            several = " or ".join(f"{role}={name}" for name in best)
            raise RecordingError(
                f"{table.path}: which column is {role}? give --column {several}, or {role}=none"
            )
        guesses[role] = best[0]
    return guesses


def _distinct(table: LogTable, names: list[str]) -> list[str]:
    """Return the first of columns that hold the same, such as a time beside each signal."""
    columns = {
        (numbers.tobytes() if (numbers := table.numbers.get(name)) is not None else name): name
        for name in reversed(names)
    }
    return sorted(columns.values(), key=names.index)


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
        words = set(_words(name))
        if measured == "time" or words & set(_OTHERS.split()):
            return None
        if words & set(_COMMANDS.split()):
            return f"{measured}_command", 1
        return (measured, 1) if words & set(_ACTUAL.split()) else None
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
    number = re.fullmatch(r"(?:0x)?(r?)0*(\w{2,4}?)h?(?:_\d+)?", joined)
    if number and (key := number[1] + number[2]) in _NUMBERED:
        return _NUMBERED[key], 2 if key in _CURRENTS else 1
    return _described(words)


def _described(words: list[str]) -> tuple[str, int] | None:
    """Return role and rank of a name whose words tell quantity and kind."""
    known = set(words)
    commanded, actual, added, forward = (
        bool(known & set(kind.split())) for kind in (_COMMANDS, _ACTUAL, _ADDED, _FEEDFORWARD)
    )
    kinds = f"{_COMMANDS} {_ACTUAL} {_FILLERS} {_ADDED} {_FEEDFORWARD}".split()
    core = "_".join(word for word in words if word not in kinds)
    bases = {base for base, names in _BASES.items() if known & set(names.split())}
    if commanded or actual or added or forward:
        bases |= {role for role, symbols in _SYMBOLS.items() if core in symbols.split()}
        bases |= {"current"} if core in _WEAK["force"].split() else set()
    if "friction" in bases:
        bases = {"friction"}
    if bases > {"current"}:  # such as a current that makes torque
        bases -= {"current"}
    if len(bases) != 1:
        return None
    (base,) = bases
    role, rank = ("force", 2) if base == "current" else (base, 1)
    if (role == "force" and (added or forward)) or (role == "velocity" and added):
        return f"added_{role}", rank
    if added or known & set(_OTHERS.split()):
        return None
    if commanded and role in ("position", "velocity", "force"):
        role = f"{role}_command"
    return role, rank


def _words(name: str) -> list[str]:
    """Return the words of the last component of a name, in small letters, without a unit."""
    last = re.sub(r"^.*[.:/](?=\s*[^\W\d_])", "", _split_suffix(name)[0])
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", last)
    words = [word.lower() for word in re.split(r"[\W_]+", spaced) if word]
    return [part for word in words for part in _parts(word)]


def _parts(word: str) -> list[str]:
    """Return quantity and kind of a German compound, else the word."""
    if not (match := _COMPOUND.fullmatch(word)):
        return [word]
    first, _, quantity, _, last, _ = match.groups()
    return [quantity, *filter(None, (first, last))]


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
