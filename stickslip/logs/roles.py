"""The roles of a log's columns: from its description, or detected from common names."""

import re
from collections.abc import Iterator, Mapping

from stickslip.errors import RecordingError
from stickslip.logs.description import ROLES, Description
from stickslip.logs.recording import Finding
from stickslip.logs.table import LogTable
from stickslip.logs.units import QUANTITIES, quantities_of, quantity_key, unit_fitting, unit_named

_EXACT = {
    "time": "t time timestamp zeitstempel time_stamp x_value",
    "position": "x q y qm pos position x_enc x_m q_m theta phi angle qpos mpos fpos apos",
    "velocity": "v dq dx vel velocity speed omega w v_m xdot qdot dqm dqdt x_dot q_dot theta_dot "
    "phi_dot thetadot phidot dtheta dphi qvel mspeed fvel",
    "force": "f tau f_m tau_m tau_j force torque motor_force motor_torque",
    "friction": "friction f_f friction_force friction_torque tau_f",
    "position_command": "qg ref reference setpoint x_d q_d theta_d phi_d x_r q_r theta_r r dpos "
    "rpos",
    "velocity_command": "v_d v_r dq_d dq_r omega_d omega_r rvel",
    "force_command": "tau_d tau_j_d tau_r",
}
_WEAK = {
    "force": "u i iq i_q vir motor_current motorstrom corriente",
    "time": "tout index date datum date_time datetime elapsed clock stamp epoch ts",
}
_SYMBOLS = {
    "position": "x q s y pos phi theta",
    "velocity": "v n w vel omega qd dq dx",
    "force": "f m tau",
    "current": "i iq i_q",
}
"""Symbols of a signal where a word beside them tells whether it is actual or commanded."""
_ACTUAL = (
    "act actual ist istwert meas measured fb feedback present estimate estimated est observed mes"
)
_FILLERS = (
    "value wert val smoothed filtered geglättet glatt co joint axis motor drive servo shaft state "
    "states data field"
)
"""Words that change nothing."""
_BASES = {
    "time": "time seconds zeit uhrzeit temps tempo tiempo",
    "position": "position positions pos posn angle displacement encoder enc theta travel stroke "
    "lage winkel drehwinkel weg hub posizione",
    "velocity": "velocity velocities vel velo speed omega rpm geschwindigkeit drehzahl vitesse "
    "velocità velocidad",
    "force": "force torque torques tau thrust effort efforts loadcell kraft moment drehmoment trq "
    "couple",
    "current": "current cur curr strom courant corrente",
    "friction": "friction reibung",
}
_SENSORS = "encoder enc"  # words of a position, unless another quantity is named beside them
_COMMANDS = (
    "cmd command commanded ref reference setpoint set target desired demand soll sollwert goal "
    "input des dem demanded tgt sp setp nominal planned traj trajectory profile request requested "
    "req wanted consigne consigna vorgabe ipo interpolated control ctrl"
)
_OTHERS = (
    "error err deviation limit max min std normal status mode ff feedforward acc accel "
    "acceleration beschleunigung jerk lag diff difference delta following tracking abweichung "
    "regelabweichung grenze grenzwert temperature temperatur vorsteuerung fehler schleppfehler "
    "schleppabstand offset power leistung voltage spannung latency delay jitter duration cycle "
    "period dt ext external contact disturbance gravity coriolis inertia model predicted rated "
    "brake gain electrical elec id"
)
"""Names of unrelated signals."""
_OTHER_CURRENTS = "d in bus dc supply battery phase field feldbildend"
"""Words of currents that make no torque."""
_LESSER = "load last raw modulo mean average avg secondary uncorrected without"
"""Words of signals that are taken where no other is as good."""
_COMPONENTS = "x y z q d"  # components of a vector whose name says what it measures: current.q
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
    ("torque", r"torque|(moment|coppia|(^|_)(couple|tau))(_|$)"),
    ("angle", r"(^|_)(angle|theta|phi|\w*winkel)(_|$)"),
)
"""What a column's name says that it measures; the first that fits."""

_MEASURED = {"time": "time", "current": "force", "voltage": "force"} | {
    quantity: role for motion in QUANTITIES.values() for role, quantity in motion.items()
}
"""What a column is whose unit measures this."""
_SAYS_ACTUAL, _SYMBOL, _WORDS, _UNIT, _CURRENT, _LEAST = range(6)
"""Ranks of what makes a column a candidate for a role, best first."""


def _sets(named: Mapping[str, str]) -> dict[str, frozenset[str]]:
    return {key: frozenset(words.split()) for key, words in named.items()}


_ROLES_OF = {name: role for role, names in _EXACT.items() for name in names.split()}
_WEAKLY = {name: role for role, names in _WEAK.items() for name in names.split()}
_BASE_WORDS, _SYMBOL_WORDS = _sets(_BASES), _sets(_SYMBOLS)
_KINDS = _sets(
    {
        "commanded": _COMMANDS, "actual": _ACTUAL, "added": _ADDED, "forward": _FEEDFORWARD,
        "filler": _FILLERS, "other": _OTHERS, "lesser": _LESSER,
    }
)  # fmt: skip
_MEANT = frozenset().union(*_BASE_WORDS.values(), *_KINDS.values()) - _KINDS["filler"]
"""Words in front of a component of a vector that say what it is."""
_LONGEST_NAME = 200
_PATH = r"[.:/](?=\s*[^\W\d_])"  # what separates the components of a name
_SHOWN = 8
_NO_SUFFIXES = ("in", "min", "mil", "pulse", "pulses", "second", "sample", "turn", "rot", "lu")
"""Units that are other words at the end of a name."""


def assign_roles(table: LogTable, description: Description) -> tuple[dict[str, str], list[Finding]]:
    """Return column names by role, and remarks; raise RecordingError where one is not clear."""
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
    remarks = [*_contradictions(found)]
    open_roles = [role for role in ROLES if description.column(role).name is None]
    guesses = _guesses(table, open_roles, set(found.values()), description)
    if not guesses:
        return found, remarks
    used = {*found.values(), *guesses.values()}
    rest = [name for name in table.names if name not in used]
    figure = ", ".join(f"{role} = {name}" for role, name in guesses.items())
    if rest:
        more = [f"{len(rest) - _SHOWN} more"] if len(rest) > _SHOWN else []
        figure = f"{figure}; not used: {', '.join([*rest[:_SHOWN], *more])}"
    advice = "<column ROLE=NAME> overrides one, <column ROLE=none> omits it"
    what = "columns detected by their names and units"
    remarks.append(Finding("note", what, figure, advice))
    if "force_command" in guesses and not {"force", "friction"} & {*found, *guesses}:
        what = f"'{guesses['force_command']}' is a set point of the force, not a measured one"
        advice = "log the force or the current; <column force=none> leaves it out"
        remarks.append(Finding("warning", what, advice=advice))
    return found | guesses, remarks


def _guesses(
    table: LogTable, roles: list[str], taken: set[str], description: Description
) -> dict[str, str]:
    candidates: dict[str, dict[int, list[str]]] = {}
    for name in table.names:
        if name in taken or not (name in table.numbers or (name in table.texts and is_time(name))):
            continue
        if found := _role_of(name, table.units.get(name)):
            role, rank = found
            candidates.setdefault(role, {}).setdefault(rank, []).append(name)
    guesses = {}
    for role in roles:
        if role not in candidates:
            continue
        best = _distinct(table, candidates[role][min(candidates[role])])
        if len(best) > 1 and role == "time" and description.sample_period:
            continue
        if len(best) > 1:
            several = " or ".join(best[:_SHOWN])
            raise RecordingError(
                f"{table.path}: which column is {role}, {several}? give <column {role}=NAME>, or "
                f"<column {role}=none>"
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


def _contradictions(given: Mapping[str, str]) -> Iterator[Finding]:
    """Yield a warning for each column that is given a role of another quantity than its name."""
    for role, name in given.items():
        named, rank = role_named(name) or (role, _SYMBOL)
        if rank != _SYMBOL and quantity_key(named) != quantity_key(role):
            what = f"column '{name}' is read as {role}, but its name is that of a {named}"
            advice = f"if that is not meant, leave out <column {role}={name}>"
            yield Finding("warning", what, advice=advice)


def is_time(name: str) -> bool:
    """Tell whether a column's name is that of a time."""
    return (role_named(name) or ("",))[0] == "time"


def _role_of(name: str, stated: str | None) -> tuple[str, int] | None:
    """Return role and rank of a column, by its name and the unit that it states."""
    found = role_named(name)
    fits = () if found is None else quantities_of(found[0])
    unit = unit_fitting(stated or suffix_unit(name) or "", fits)
    if unit is None or unit.quantity.startswith("number"):
        return found
    measured = _MEASURED.get(unit.quantity)
    if measured not in ("time", "position", "velocity", "force"):
        return None
    electric = unit.quantity in ("current", "voltage")
    if found is None or (found[0] == "time" and measured != "time"):  # such as T [N.m]
        words = set(_words(name))
        if words & _KINDS["other"] or (electric and words & set(_OTHER_CURRENTS.split())):
            return None
        if words & _KINDS["commanded"]:
            return None if measured == "time" else (f"{measured}_command", _UNIT)
        if unit.quantity == "voltage":
            return None
        lesser = bool(words & _KINDS["lesser"])
        return measured, _LEAST if lesser else _CURRENT if electric else _UNIT
    role, rank = found
    if quantity_key(role) == measured:
        return role, max(rank, _CURRENT) if electric else rank
    commanded = role.endswith("_command") and measured != "time"
    return (f"{measured}_command", rank) if commanded else None


def role_named(name: str) -> tuple[str, int] | None:
    """Return role and rank of a column's name, None when it says nothing."""
    if len(name) > _LONGEST_NAME:
        return None
    *parents, last = re.split(_PATH, name)
    digits = "_".join(_words(last, digits=True))
    number = re.fullmatch(r"(?:0x)?(r?)0*(\w{2,4}?)h?(?:_\d+)?", digits)
    if number and (key := number[1] + number[2]) in _NUMBERED:
        return _NUMBERED[key], _CURRENT if key in _CURRENTS else _WORDS
    words = _words(last)
    joined = "_".join(words)
    above = _words(parents[-1]) if parents else []
    if (joined in _COMPONENTS.split() and _MEANT & set(above)) or (
        joined in _ROLES_OF and (_KINDS["commanded"] | _KINDS["actual"]) & set(above)
    ):
        return _described([*above, *words])
    for rank, table in ((_SYMBOL, _ROLES_OF), (_CURRENT, _WEAKLY)):
        if joined in table:
            return table[joined], rank
    found = _described(words)
    silent = _KINDS["commanded"] | _KINDS["actual"] | _KINDS["filler"]
    return _described([*above, *words]) if found is None and silent.issuperset(words) else found


def _described(words: list[str]) -> tuple[str, int] | None:
    """Return role and rank of a name whose words tell quantity and kind."""
    known = set(words)
    kinds = {kind for kind, names in _KINDS.items() if known & names}
    said = kinds & {"commanded", "actual", "added", "forward"}
    neutral = frozenset().union(*(_KINDS[kind] for kind in (*said, "filler")))
    core = "_".join(word for word in words if word not in neutral)
    bases = {base for base, names in _BASE_WORDS.items() if known & names}
    if len(bases) > 1 and not known & _BASE_WORDS["position"] - set(_SENSORS.split()):
        bases -= {"position"}
    if not bases and core in _ROLES_OF and len(words) > 1:
        bases = {_ROLES_OF[core]}
    elif not bases and said:
        bases = {base for base, symbols in _SYMBOL_WORDS.items() if core in symbols}
    if "friction" in bases:
        bases = {"friction"}
    if bases > {"current"}:  # such as a current that makes torque
        bases -= {"current"}
    if len(bases) != 1:
        return None
    (base,) = bases
    current = base == "current"
    role, rank = "force" if current else base, _SAYS_ACTUAL if "actual" in kinds else _WORDS
    rank = _CURRENT if current else _LEAST if "lesser" in kinds else rank
    if said & {"added", *(["forward"] if role == "force" else [])} and role in (
        "force",
        "velocity",
    ):
        return f"added_{role}", rank
    if kinds & {"added", "other"} or (current and known & set(_OTHER_CURRENTS.split())):
        return None
    if "commanded" in kinds and role in ("position", "velocity", "force"):
        role = f"{role}_command"
    return role, rank


def _words(name: str, *, digits: bool = False) -> list[str]:
    """Return the words of a name, in small letters, without a unit and without numbers."""
    spaced = _spaced(_split_suffix(name)[0])
    words = [word.lower() for word in re.split(r"[\W_]+", spaced) if word]
    if not digits:
        words = [word for text in words if (word := text.rstrip("0123456789"))]
    return [part for word in words for part in _parts(word)]


def _parts(word: str) -> list[str]:
    """Return quantity and kind of a German compound, else the word."""
    if not (match := _COMPOUND.fullmatch(word)):
        return [word]
    first, _, quantity, _, last, _ = match.groups()
    return [quantity, *filter(None, (first, last))]


def named_quantity(name: str) -> str | None:
    """Return what a column's name says that it measures: current, torque and so on, else None."""
    last = re.split(_PATH, name[:_LONGEST_NAME])[-1]
    plain = "_".join(_words(last)) + "".join(re.findall("[%‰]", name))
    return next((quantity for quantity, pattern in _NAMED if re.search(pattern, plain)), None)


def suffix_unit(name: str) -> str | None:
    """Return what may be a unit at the end of a name such as ``force_N`` or ``v_mm_s``."""
    return _split_suffix(name)[1] if len(name) <= _LONGEST_NAME else None


def _spaced(name: str) -> str:
    """Return a name with its words apart, but units such as mNm whole."""
    words = name.replace(" ", "_").split("_")
    return "_".join(w if unit_named(w) else re.sub("(?<=[a-z])(?=[A-Z])", "_", w) for w in words)


def _split_suffix(name: str) -> tuple[str, str | None]:
    """Return a name without its unit, and the unit; an index or a name like millis is none."""
    words = [word for word in _spaced(name).split("_") if word]
    for count in (3, 2, 1):
        head, tail = "_".join(words[:-count]), words[-count:]
        if len(tail) < count or (count == 3 and tail[1] != "per"):
            continue
        signs = ("/", ".") if count == 2 else ("/",)
        for text in (sign.join((tail[0], tail[-1])) for sign in signs) if count > 1 else tail:
            if unit_named(text) and (count > 1 or _is_suffix(head, text)):
                return head or name, text
    return name, None


def _is_suffix(head: str, text: str) -> bool:
    if len(text) == 1:
        index = len(head) <= 1 and head.lower() not in ("t", "f", "i")
        return text in ("s", "N", "A", "V") and bool(head) and not index
    return text.lower() not in _NO_SUFFIXES
