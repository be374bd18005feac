"""model.toml: the one place where a model's variables are written down."""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, Self, get_args

from stickslip.models.errors import DescriptionError, StartValueError
from stickslip.models.export import units
from stickslip.models.export.law import MODELS, Law, merge, read_law, read_toml, require_known

Role = Literal[
    "time", "input", "state", "mode", "derivative", "indicator", "output", "memory", "parameter"
]
Kind = Literal["constant", "fixed", "tunable", "discrete", "dependent"]
Type = Literal["real", "integer", "boolean"]
# Sections of model.toml in value-reference order.
_SECTIONS: dict[str, Role] = {
    "inputs": "input",
    "states": "state",
    "modes": "mode",
    "events": "indicator",
    "outputs": "output",
    "memory": "memory",
    "parameters": "parameter",
}
ROLES = {"v_ref", "x_enc", "v_est", "u", "F_motor", "F_added"}
"""Signals of a loop: reference velocity, encoder position, velocity that the controller estimates,
the controller's force command, motor force, force of the compensator before this one in a chain."""
AXIS = {"T_s", "tau_f", "m", "b", "tau_i"}
"""Sample period and low-pass of the loop; mass, viscous friction, current-loop lag of its axis."""
_TYPES: tuple[Type, ...] = ("real", "integer", "boolean")
_KEYS = {
    *("unit", "display", "description", "type", "size", "start", "min", "max", "nominal"),
    *("output", "derivative", "depends", "uses", "held", "variability"),
}
_VARIABILITY = {"memory": "discrete", "mode": "discrete", "parameter": "fixed"}
_OPEN = {"min": None, "max": None}
_KINDS: tuple[Kind, ...] = get_args(Kind)
_STOP, _STEP = 1.0, 5e-4  # s, where model.toml has no [experiment]


@dataclass(frozen=True)
class Variable:
    """One scalar variable; its value reference is its place in ``Model.variables``.

    ``start``, ``minimum``, ``maximum`` and ``nominal`` are in ``unit``; booleans are 0 and 1.
    ``depends`` says of an output or a derivative on which inputs and states it depends and how
    (FMI 2.0.4 and 3.0.2, dependenciesKind), ``uses`` on which parameters and, where it has no
    derivative, on which states; ``of`` says of a derivative whose it is; ``held`` says of an output
    that it belongs to the last step, so that steps begin with 0.
    """

    name: str
    role: Role
    description: str
    type: Type = "real"
    unit: str | None = None
    display: str | None = None
    start: float = 0.0
    minimum: float | None = None
    maximum: float | None = None
    nominal: float | None = None
    is_output: bool = False
    depends: Mapping[str, Kind] = field(default_factory=dict)
    uses: tuple[str, ...] = ()
    of: str | None = None
    held: bool = False
    variability: str = "continuous"


@dataclass(frozen=True)
class Terminal:
    """Variables that are connected together; ``members`` maps the plug's names to them."""

    description: str
    members: Mapping[str, str]


@dataclass(frozen=True)
class Ports:
    """How a compensator is connected in a loop: ``[loop]`` of model.toml.

    Attributes
    ----------
    inputs : input -> role of the signal that it takes, one of ``ROLES``
    output : the force that is added to the controller's
    tuned : parameters that are tuned; a compensator that runs a law tunes the law's as well
    axis : parameter -> what it is set to: a number, or one of ``AXIS`` of the drive
    learned : parameter -> variable whose value at the end of a run it takes over to another run; of
        an array, by its name alone, all elements
    frozen : parameters with which it goes on without learning
    """

    inputs: Mapping[str, str]
    output: str
    tuned: tuple[str, ...]
    axis: Mapping[str, str | float]
    learned: Mapping[str, str] = field(default_factory=dict)
    frozen: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Model:
    """What model.toml says, and the C files that go with it.

    ``fields`` are the members of the C structs by role: name and size, ``()`` for a scalar.
    ``sampled`` says that it does nothing between the samples it takes. ``icon`` is drawn of
    polylines on a tile of 100 by 100. ``law`` is the friction law that it
    contains, ``ports`` how a compensator is connected, ``sources`` the C of the law whose equations
    it uses without containing it. ``rotary`` says that the units are those of a rotary drive.
    """

    name: str
    title: str
    description: str
    stop: float
    step: float
    variables: tuple[Variable, ...]
    fields: Mapping[Role, tuple[tuple[str, tuple[int, ...]], ...]]
    folder: Path
    version: str | None = None
    sampled: bool = False
    terminals: Mapping[str, Terminal] = field(default_factory=dict)
    icon: tuple[tuple[float, ...], ...] = ()
    law: Law | None = None
    ports: Ports | None = None
    sources: tuple[Path, ...] = ()
    rotary: bool = False

    @property
    def is_continuous(self) -> bool:
        """Tell whether its equations are differential ones without memory of steps."""
        return any(v.role == "derivative" for v in self.variables)

    @property
    def is_switched(self) -> bool:
        """Tell whether its equations have modes, which change at state events."""
        return any(v.role == "indicator" for v in self.variables)

    @property
    def has_model_exchange(self) -> bool:
        """Tell whether a tool's solver can take it over."""
        return self.is_continuous or self.sampled

    def of_motion(self, *, rotary: bool) -> Self:
        """Return the model with the units of a linear drive, as in model.toml, or a rotary one."""

        def own(unit: str | None) -> str | None:
            return unit and units.motion_unit(unit, rotary=rotary)

        variables = (replace(v, unit=own(v.unit), display=own(v.display)) for v in self.variables)
        return replace(self, variables=tuple(variables), rotary=rotary)

    def with_start(self, start: Mapping[str, float]) -> Self:
        """Return the model with other start values.

        Raises
        ------
        StartValueError
            When a variable does not exist, is not a parameter, or is given no number of its range.
        """
        variables = {v.name: v for v in self.variables}
        for name, value in start.items():
            variable = variables.get(name)
            if variable is None or variable.role != "parameter":
                known = ", ".join(v.name for v in self.variables if v.role == "parameter")
                raise StartValueError(f"{self.name} has no parameter {name}; it has {known}")
            try:
                number = float(value)
            except (TypeError, ValueError):
                what = f"{self.name}: {name}: expected a number, got {value!r:.80}"
                raise StartValueError(what) from None
            _check_range(variable, number, StartValueError, self.name)
            variables[name] = replace(variable, start=number)
        step = variables["T_s"].start if "T_s" in start else self.step
        return replace(self, step=step, variables=tuple(variables.values()))


def read_model(folder: Path, law: Law | None = None) -> Model:
    """Read ``model.toml`` with the law that it contains; DescriptionError if not well formed."""
    content = read_toml(folder / "model.toml")
    content.setdefault("parameters", {})
    if law is not None:
        merge(content, law)
    sources: list[Path] = []
    if used := content.pop("equations", None):
        equations = read_law(MODELS / "laws" / used)
        own = content["parameters"]
        own |= {name: table | own.get(name, {}) for name, table in equations.tables.items()}
        sources = [path for path in equations.folder.glob("*.[ch]") if path.stem == used]
    try:
        names = {
            f"{name}{index}"
            for section in _SECTIONS
            for name, table in content.get(section, {}).items()
            for index in _indices(table.get("size", ()))
        }
        variables = [Variable("time", "time", "Simulation time", unit="s")]
        fields: dict[Role, tuple[tuple[str, tuple[int, ...]], ...]] = {}
        for section, role in _SECTIONS.items():
            tables = content.pop(section, {})
            # Reals first among the parameters, so that each type is one range of value references.
            order = sorted(tables, key=lambda name: _TYPES.index(tables[name].get("type", "real")))
            fields[role] = tuple((name, tuple(tables[name].get("size", ()))) for name in order)
            if role == "state":
                integrated = {n: table for n, table in tables.items() if "derivative" in table}
                fields["derivative"] = tuple(f for f in fields["state"] if f[0] in integrated)
            for name in order:
                variables += _variables(f"{folder.name}/model.toml", name, role, tables[name])
            if role == "mode":
                fields["state"] += fields.pop("mode")
                for name, table in integrated.items():
                    variables += _derivatives(name, table, names)
        times = content.get("experiment", {})
        return Model(
            name=content.get("name", folder.name),
            title=content["title"],
            description=content["description"],
            version=content["version"],
            stop=times.get("stop", _STOP),
            step=times.get("step", _STEP),
            sampled=content.get("sampled", False),
            variables=tuple(variables),
            fields=fields,
            terminals=_terminals(content.get("terminals", {}), {v.name for v in variables}),
            icon=tuple(map(tuple, content["icon"])),
            folder=folder,
            law=law,
            ports=_ports(content.get("loop"), law),
            sources=tuple(sources),
        )
    except KeyError as missing:
        raise DescriptionError(f"{folder.name}/model.toml: key {missing} is missing") from None


def _ports(table: dict[str, Any] | None, law: Law | None) -> Ports | None:
    if table is None:
        return None
    require_known("[loop]", table["inputs"].values(), ROLES)
    require_known("[loop]", (v for v in table["axis"].values() if isinstance(v, str)), AXIS)
    tuned = (*table["tuned"], *(law.parameters if law else ()))
    kept = table.get("learned", {}), table.get("frozen", {})
    return Ports(table["inputs"], table["output"], tuned, table["axis"], *kept)


def _terminals(tables: dict[str, Any], known: set[str]) -> dict[str, Terminal]:
    for name, table in tables.items():
        require_known(f"terminal {name}", table["members"].values(), known)
    return {name: Terminal(t["description"], t["members"]) for name, t in tables.items()}


def _variables(file: str, name: str, role: Role, table: dict[str, Any]) -> Iterator[Variable]:
    """Yield one variable, or one for each element of an array in C order."""
    where = f"{file}, variable {name}"
    require_known(where, table, _KEYS)
    require_known(where, filter(None, [table.get("unit")]), units.UNITS)
    shown = units.DISPLAY.get(table.get("unit", "1"), {})
    require_known(where, filter(None, [table.get("display")]), shown)
    require_known(where, table.get("depends", {}).values(), _KINDS)
    unit: str | None = table.get("unit")
    size = table.get("size", ())
    start = _flat(table.get("start", 0.0))
    indices = _indices(size)
    usual = None if role == "parameter" else units.NOMINAL.get(unit or "")
    minimum, maximum = units.parameter_range(table if role == "parameter" else {**_OPEN, **table})
    if len(start) not in (1, len(indices)):
        raise DescriptionError(f"{where}: {len(start)} start values for {len(indices)} elements")
    for place, index in enumerate(indices):
        variable = Variable(
            name=f"{name}{index}",
            role=role,
            description=table["description"],
            type=table.get("type", "real"),
            unit=unit,
            display=table.get("display", units.READ_IN.get(unit or "")),
            start=start[place if len(start) > 1 else 0],
            minimum=minimum,
            maximum=maximum,
            nominal=table.get("nominal", usual),
            is_output=role == "output" or table.get("output", False),
            depends=table.get("depends", {}),
            uses=tuple(table.get("uses", ())),
            held=table.get("held", False),
            variability=table.get("variability", _VARIABILITY.get(role, "continuous")),
        )
        _check_range(variable, variable.start, DescriptionError, file)
        yield variable


def _indices(size: Sequence[int]) -> list[str]:
    """Return what names the elements of an array in C order: ``[1,1]``; of a scalar, nothing."""
    indices = itertools.product(*(range(1, n + 1) for n in size))
    return [f"[{','.join(map(str, index))}]" if index else "" for index in indices]


def _derivatives(state: str, table: dict[str, Any], names: set[str]) -> Iterator[Variable]:
    """Yield derivatives of a state; ``name[]`` is the element of its index among ``names``."""
    for index in _indices(table.get("size", ())):
        uses = {n: n.replace("[]", index) for n in table.get("uses", ())}
        yield Variable(
            name=f"der({state}{index})",
            role="derivative",
            description=f"Derivative of: {table['description']}",
            unit=units.rate_unit(table["unit"]),
            depends={n.replace("[]", index): kind for n, kind in table["derivative"].items()},
            uses=tuple(n for given, n in uses.items() if n == given or n in names),
            of=f"{state}{index}",
        )


def _flat(value: Any) -> list[float]:
    if isinstance(value, list):
        return [number for item in value for number in _flat(item)]
    return [float(value)]


def _check_range(v: Variable, value: float, error: type[Exception], where: str) -> None:
    low = v.minimum if v.minimum is not None else float("-inf")
    high = v.maximum if v.maximum is not None else float("inf")
    if not (low <= value <= high) or value in (float("inf"), float("-inf")):
        unit = v.unit or ""
        raise error(f"{where}: {v.name} = {value:g} {unit} is outside {low:g} .. {high:g} {unit}")
