"""law.toml: the one place where a friction law's states and parameters are written down."""

import math
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from stickslip.fmi.additions import own_folder
from stickslip.models.errors import DescriptionError
from stickslip.models.export.units import (
    READ_IN,
    UNITS,
    force_and_length,
    parameter_range,
)

Steady = Literal["coulomb", "stribeck", "lorentz"]
Coordinate = Literal["log", "linear"]
End = Literal["low", "high"]
MODELS = Path(__file__).parents[1]
_OPTIONAL = {"at_least", "spread", "shown_by", "requires", "weakest"}
_KNOWLEDGE = {"symbol", "coordinate", "choices", *_OPTIONAL}
_KEYS = {"title", "description", "steady", "passive", "smooth", "candidate", "co_simulation_only"}
_TABLES = {"parameters", "states", "modes", "events", "force"}
STEADY = ("coulomb", "stribeck", "lorentz")
"""What the force at constant speed may be."""


def roots() -> tuple[Path, Path]:
    """Return the folders that contain laws and models: of this package, and of the user."""
    return MODELS, own_folder()


@dataclass(frozen=True)
class LawParameter:
    """One parameter of a law, with what estimation and reports need to know of it.

    Attributes
    ----------
    name, unit, description, start, low, high : as in the FMU; ``start`` has one value an element
    display : unit in which people read it, None for ``unit``
    symbol : formula, for matplotlib and LaTeX
    coordinate : ``log`` or ``linear``, in which it is searched
    at_least : name of the parameter that it must not fall below, None for none
    spread : standard deviation of its natural logarithm when a data sheet or a single slow run is
        all that is known, None where nothing is known
    shown_by : the experiment that shows it, None for a parameter that is chosen and not estimated
    requires : name of a parameter with ``at_least``; only while that one is above its bound does
        this one have an effect. None for no such parameter
    weakest : end of its interval at which the force is the weakest
    choices : values to choose from, the preferred one first; empty for ``start`` alone
    force, length : powers of the units of force and length in its unit. The parameters with
        ``force == 1`` are those to multiply for a share of the force at the same motion
    """

    name: str
    unit: str
    description: str
    start: tuple[float, ...]
    low: float
    high: float
    display: str | None
    symbol: str
    coordinate: Coordinate
    force: int
    length: int
    choices: tuple[float, ...]
    at_least: str | None = None
    spread: float | None = None
    shown_by: str | None = None
    requires: str | None = None
    weakest: End = "low"


@dataclass(frozen=True)
class Law:
    """A friction law.

    Attributes
    ----------
    name : of its folder in models/laws
    title, description : display name, and a sentence
    co_simulation_only : why no solver of a tool can take its equations; None where one can
    steady : the force at constant speed: ``coulomb``, F_c; ``stribeck``, equation (4); ``lorentz``,
        F_c + (F_s - F_c) / (1 + (v / v_s)^2) after a long time at rest
    is_passive : whether it never gives more energy than it was given, without viscous friction
    is_smooth : whether its equations are differential ones without events, which a solver can take
    is_candidate : whether ``learn --law auto`` considers it; false unless law.toml says so
    parameters : by name, in the order of law.toml
    states, modes, events, force : tables of law.toml. ``modes`` are states that change at events,
        and ``events`` the event indicators, in plants with Model Exchange; ``force`` tells what the
        force depends on
    """

    name: str
    title: str
    description: str
    co_simulation_only: str | None
    steady: Steady
    is_passive: bool
    is_smooth: bool
    is_candidate: bool
    parameters: Mapping[str, LawParameter]
    states: Mapping[str, Mapping[str, Any]]
    modes: Mapping[str, Mapping[str, Any]]
    events: Mapping[str, Mapping[str, Any]]
    force: Mapping[str, Any]
    folder: Path
    tables: Mapping[str, Mapping[str, Any]]

    def share(self, values: Mapping[str, float], share: float) -> dict[str, float]:
        """Return parameters whose force is a share of that of ``values`` at the same motion.

        They are at least the smallest values that FMUs of the law accept; a value below is kept,
        for FMUs to refuse.
        """
        least = {name: one.low for name, one in self.parameters.items() if one.force}
        return {
            name: max(share * value, low)
            if (low := least.get(name.partition("[")[0], math.inf)) <= value
            else value
            for name, value in values.items()
        }


def read_toml(path: Path) -> dict[str, Any]:
    """Return a TOML file with those that it includes; DescriptionError if not well formed."""
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise DescriptionError(f"{path}: {error}") from None
    included = content.pop("include", [])
    for file in [included] if isinstance(included, str) else included:
        for section, shared in read_toml(MODELS / file).items():
            own = content.get(section, {})
            content[section] = {name: table for name, table in shared.items() if name not in own}
            content[section] |= {name: shared.get(name, {}) | table for name, table in own.items()}
    return content


def require_known(where: str, words: Iterable[Any], known: Iterable[Any]) -> None:
    """Raise DescriptionError where a word is not among those that are known."""
    allowed = list(known)
    if unknown := sorted(set(words) - set(allowed)):
        raise DescriptionError(f"{where}: {unknown[0]} is unknown; expected one of {allowed}")


def read_law(folder: Path) -> Law:
    """Read ``law.toml`` in a law's folder; DescriptionError when the file is not well formed."""
    content = read_toml(folder / "law.toml")
    require_known(f"{folder.name}/law.toml, its keys", content, sorted(_KEYS | _TABLES))
    try:
        given = content["parameters"].items()
        tables = {name: {"variability": "tunable", **table} for name, table in given}
        file = f"{folder.name}/law.toml"
        for name, table in tables.items():
            require_known(f"{file}, {name}", [table["unit"]], UNITS)
            require_known(f"{file}, {name}", [table.get("coordinate", "log")], ("linear", "log"))
            if not all(isinstance(one, int | float) for one in _listed(table["start"])):
                what = f"start is {table['start']!r}, expected a number"
                raise DescriptionError(f"{file}, {name}: {what}")
        require_known(f"{file}, steady", [content["steady"]], STEADY)
        for word in ("passive", "smooth"):
            require_known(f"{file}, {word}", [content[word]], (False, True))
        law = Law(
            name=folder.name,
            title=content["title"],
            description=content["description"],
            co_simulation_only=content.get("co_simulation_only"),
            steady=content["steady"],
            is_passive=content["passive"],
            is_smooth=content["smooth"],
            is_candidate=content.get("candidate", False),
            parameters={name: _parameter(name, table) for name, table in tables.items()},
            states=content.get("states", {}),
            modes=content.get("modes", {}),
            events=content.get("events", {}),
            force=content["force"],
            folder=folder,
            tables={
                name: {key: value for key, value in table.items() if key not in _KNOWLEDGE}
                for name, table in tables.items()
            },
        )
    except KeyError as missing:
        raise DescriptionError(f"{folder.name}/law.toml: key {missing} is missing") from None
    if not law.states:
        what = "expected at least one state, such as the deflection of a bristle, got none"
        advice = "a force of the velocity alone is a compensator, as static_feedforward"
        raise DescriptionError(f"{folder.name}/law.toml, states: {what}; {advice}")
    for p in law.parameters.values():
        where = f"{folder.name}/law.toml, parameter {p.name}"
        require_known(where, filter(None, (p.at_least, p.requires)), law.parameters)
    names = {*law.parameters, *law.states, *law.modes, *law.events}
    for name, whose in {**law.states, **law.modes, "force": law.force}.items():
        used = [one.removesuffix("[]") for one in whose.get("uses", ())]
        require_known(f"{folder.name}/law.toml, {name}, uses", used, sorted(names))
    if not (folder / "law.c").is_file():
        raise DescriptionError(f"{folder.name}: expected law.c beside law.toml, got none")
    return law


def _listed(start: Any) -> list[Any]:
    return start if isinstance(start, list) else [start]


def _parameter(name: str, table: Mapping[str, Any]) -> LawParameter:
    force, length = force_and_length(table["unit"])
    low, high = parameter_range(table)
    return LawParameter(
        name=name,
        unit=table["unit"],
        description=table["description"],
        start=tuple(map(float, _listed(table["start"]))),
        low=table["min"] if low is None else low,
        high=table["max"] if high is None else high,
        display=table.get("display", READ_IN.get(table["unit"])),
        symbol=table["symbol"],
        coordinate=table.get("coordinate", "linear"),
        force=force,
        length=length,
        choices=tuple(map(float, table.get("choices", ()))),
        **{key: table[key] for key in _OPTIONAL & table.keys()},
    )


def merge(content: dict[str, Any], law: Law) -> None:
    """Add a law's states and parameters to the content of a model.toml.

    In ``depends``, ``derivative`` and ``uses`` of the model, ``law`` stands for what the law's
    force depends on; ``uses_with_level`` is used where that includes the level of friction. Where a
    state of the model has no derivative, the law's have none either; those of a sampled model are
    memory, without a range. A law with events is integrated with the mass it acts on, so the model
    must have states of its own. DescriptionError when a name of the law is one of the model's.
    """
    own = content.setdefault("states", {})
    roles = ("inputs", "states", "memory", "outputs", "parameters")
    taken = {name for role in roles for name in content.get(role, {})}
    if twice := sorted(taken & {*law.states, *law.tables}):
        what = f"{law.name}/law.toml: {twice[0]} is a variable of the model as well"
        raise DescriptionError(what)
    states = {name: dict(table) for name, table in law.states.items()}
    sampled = content.get("sampled", False)
    integrated = not sampled and all("derivative" in table for table in own.values())
    integrated = integrated and bool(law.is_smooth or (law.events and own))
    if not integrated:
        for table in (*own.values(), *states.values()):
            table.pop("derivative", None)
            table.pop("uses", None)
    inputs = content.get("inputs", {})
    force = law.force["depends"]
    moving = {name for name in force if "derivative" in states.get(name, {"derivative": None})}
    names = moving if integrated else inputs.keys() & force.keys()
    known = {n: kind for name, kind in force.items() if name in names for n in _parts([name], law)}
    if integrated and law.force.get("reaction"):
        known |= dict.fromkeys(inputs, "dependent")
    uses = [*(name for name in force if name not in names), *law.force["uses"]]
    has_level = "F_c" in law.force["uses"]
    for table in (*own.values(), *content["outputs"].values()):
        for key in {"depends", "derivative"} & table.keys():
            if table[key].pop("law", None):
                fixed = "fixed" if key == "derivative" else "constant"
                table[key] |= {n: fixed if k == "constant" else k for n, k in known.items()}
        at_level = table.pop("uses_with_level", [])
        if "law" in table.get("uses", ()):
            used = [name for name in table["uses"] if name != "law"]
            is_rate = "derivative" in table
            now = [n for n in uses if not (is_rate and states.get(n, {}).get("held"))]
            table["uses"] = [*used, *_parts(now, law), *(at_level if has_level else [])]
    for table in states.values():
        if "derivative" in table:
            depends = table["derivative"]
            table["derivative"] = {n: k for name, k in depends.items() for n in _parts([name], law)}
            table["uses"] = list(_parts(table["uses"], law))
    if sampled:  # nobody sets memory, so it has no range of values that are accepted
        for table in states.values():
            table.pop("min", None)
            table.pop("max", None)
    content["memory" if sampled else "states"] |= states
    if integrated:
        content |= {"modes": dict(law.modes), "events": dict(law.events)}
    content["parameters"] |= law.tables
    content |= {key: content[key].format(law=law.title) for key in ("title", "description")}
    if law.co_simulation_only:
        content["description"] += f". Co-Simulation only: {law.co_simulation_only}"


def _parts(names: Iterable[str], law: Law) -> Iterator[str]:
    """Yield the names of scalar variables; the arrays of a law have one dimension."""
    tables = {**law.tables, **law.states}
    for name in names:
        sizes = tables.get(name, {}).get("size", [])
        yield from (f"{name}[{k + 1}]" for n in sizes for k in range(n))
        if not sizes:
            yield name
