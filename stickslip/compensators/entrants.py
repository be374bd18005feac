"""What competes: compensators, the controller alone, and combinations such as ``lugre+ekbf``.

An entrant is data; see ``entrants.toml`` for what an entry says and for what enters without one.
"""

import re
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from stickslip import cosim, ga, models
from stickslip.catalog.parameters import PAPER, estimated, friction_law, parameter, scaled_start
from stickslip.compensators.names import content, part_names, require_parts
from stickslip.errors import UsageError
from stickslip.fmi.files import MOST_TEXT, parse_toml, read_limited
from stickslip.fmi.messages import suggestion
from stickslip.models.export.description import AXIS, ROLES, Variable
from stickslip.models.export.units import force_and_length
from stickslip.servo.axis import Datasheet
from stickslip.servo.chain_response import ChainResponse, Robustness
from stickslip.servo.systems import COMPONENTS, Compensator
from stickslip.servo.velocity_filter import FilterSpecification, design_velocity_filter
from stickslip.servo.velocity_loop import VelocityLoop, position_loop

FEEDFORWARD = "compensator"  # model that evaluates any law
RANGE = 10.0  # bounds of a parameter of a friction law, as a factor on its coarse start
SPEED = 0.04  # speed of the paper's commands [m/s], for which ``entrants.toml`` is written
SPREAD = 0.5  # standard deviation of the logarithm of a start value where law.toml gives none
DEFLECTION = 2e-5  # presliding deflection that is assumed before tuning, at that speed [m]


@dataclass(frozen=True)
class Coarse:
    """What is known of a drive before it is tuned."""

    friction: float  # measured force of sliding [N]
    speed: float  # largest speed of the training command [m/s]
    seed: int = 0  # of the errors of the coarse start values

    def start(self, name: str, law: models.Law | None = None) -> float:
        """Return a start value of a friction parameter, with an error as of a data sheet."""
        known = _known(name, law)
        value = scaled_start(known, self.friction, DEFLECTION * self.speed / SPEED)
        rng = np.random.default_rng([self.seed, zlib.crc32(name.encode())])
        value *= np.exp((known.spread or SPREAD) * rng.standard_normal())
        return float(np.clip(value, known.low, known.high))

    def scale(self, unit: str) -> float:
        """Return the factor on values of a unit that hold for the paper's stage."""
        force, length = force_and_length(unit)
        return float((self.friction / PAPER["F_c"]) ** force * (self.speed / SPEED) ** length)


@dataclass(frozen=True)
class TunedEntrant:
    """An entrant with values for its genes, ready to run in a loop."""

    loop: VelocityLoop  # with the gains that it chooses
    parameters: Mapping[str, float]  # start values of the FMUs of its chain, ``component.variable``
    # parameters of the controller's nonlinear damping; empty for none
    damping: Mapping[str, float] = field(default_factory=dict)

    def robustness(
        self, response: ChainResponse, friction: float, m: float | None = None
    ) -> Robustness:
        """Return the worst robustness of the loops between which nonlinear damping moves.

        Friction is that of sliding [N], m the true mass [kg]; raises ControlError.
        """
        loops = [self.loop]
        if self.damping:
            loops.append(regulated(self.loop, K_p=self.loop.K_p + self.damping["gamma_v"]))
        return Robustness.worst([response.of(one, self.parameters, friction, m) for one in loops])


Design = Callable[[Mapping[str, float], VelocityLoop, Coarse, Datasheet], dict[str, float]]


def kalman(
    genes: Mapping[str, float], loop: VelocityLoop, coarse: Coarse, sheet: Datasheet, order: int = 1
) -> dict[str, float]:
    """Return the gains of a stationary Kalman filter; rate and noise are in units of friction."""
    rate, noise = genes["rate"] * coarse.friction, genes["noise"] * coarse.friction
    weights = FilterSpecification(sheet.encoder_step, noise, rate, order)
    found = design_velocity_filter(loop.axis, loop.T_s, weights)
    rest = {name: value for name, value in genes.items() if name not in ("rate", "noise")}
    gains = {"L_x": found.L_x, "L_v": found.L_v, "L_d": found.L_d}
    return gains | ({"L_1": found.L_1} if order == 2 else {}) | rest


def composite(genes: Mapping[str, float], loop: VelocityLoop) -> dict[str, float]:
    """Return gains of composite nonlinear feedback from the poles of its linear part.

    Proportional-integral control of the velocity and a position loop around it are a PID position
    controller: stiffness m w_0^2 and damping 2 zeta w_0 m. Of the genes, ``w_0`` is relative to the
    crossover K_p / m of the designed loop, ``gamma_v`` to its K_p, and ``K_x`` to its own.
    """
    w_0 = genes["w_0"] * loop.K_p / loop.axis.m
    gains = {
        "K_p": 2.0 * genes["zeta"] * w_0 * loop.axis.m,
        "K_i": loop.axis.m * w_0**2,
        "K_x": genes["K_x"] * loop.K_x,
    }
    return {**gains, "gamma_v": genes["gamma_v"] * loop.K_p, "alpha": genes["alpha"]}


def regulated(loop: VelocityLoop, **gains: float) -> VelocityLoop:
    """Return a loop with other gains [N s/m, N/m, 1/s]; raise ControlError when it is unstable."""
    return loop.changed(velocity_filter=None, velocity_feedforward=1.0, **gains)


def _is_number(value: object) -> bool:
    return isinstance(value, bool | int | float) and bool(np.isfinite(value))


def _is_text(value: object) -> bool:
    return isinstance(value, str) and bool(value)


def _table_of(fits: Callable[[Any], bool]) -> Callable[[object], bool]:
    return lambda value: isinstance(value, Mapping) and all(map(fits, value.values()))


_EXPECTED: dict[str, tuple[Callable[[object], bool], str]] = {
    **dict.fromkeys(("name", "title", "output"), (_is_text, "a text")),
    **dict.fromkeys(("inputs", "learned"), (_table_of(_is_text), "a table of texts")),
    **dict.fromkeys(("values", "frozen"), (_table_of(_is_number), "a table of numbers")),
    "axis": (
        _table_of(lambda value: _is_text(value) or _is_number(value)),
        "a table of texts and numbers",
    ),
    "genes": (
        _table_of(lambda span: isinstance(span, list | tuple) and all(map(_is_number, span))),
        "a table of [lowest, start, highest]",
    ),
}
"""What a file of ports may contain."""
DESIGNS: dict[str, Design] = {"kalman": kalman, "kalman_2": partial(kalman, order=2)}
DAMPING = ("gamma_v", "alpha")  # parameters of the controller's nonlinear damping


def factors(genes: Mapping[str, float], loop: VelocityLoop) -> dict[str, float]:
    """Return gains of a controller from factors on those of the design."""
    return {name: getattr(loop, name) * factor for name, factor in genes.items()}


REGULATORS: dict[str, Callable[[Mapping[str, float], VelocityLoop], dict[str, float]]] = {
    "": factors,
    "composite": composite,
}


@dataclass(frozen=True)
class Part:
    """One entry: a compensator, or other gains of the controller."""

    name: str
    title: str
    model: str = ""
    law: models.Law | None = None
    values: Mapping[str, float] = field(default_factory=dict)  # parameters that are not tuned
    # lowest value, start and highest value of a gene, by name
    ranges: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    design: str = ""  # of ``DESIGNS`` or ``REGULATORS``; empty where genes are parameters
    controller: bool = False
    positions: bool = False  # whether it controls the position
    experiment: str = (
        ""  # ``identified`` or ``fitted``: how the drive shows its friction parameters
    )
    own_ports: models.Ports | None = None  # how an FMU of the user is connected
    own_fmu: Path | None = None  # its file

    @property
    def file(self) -> str:
        """Name of its FMU, without suffix."""
        return f"{self.model}_{self.law.name}" if self.law else self.model

    @property
    def compensator(self) -> Compensator | None:
        """Its component in a loop; None where only the controller changes."""
        if not self.model:
            return None
        return Compensator(self.name, self.model, self.values, self.file, own_ports=self.own_ports)

    @cached_property
    def ports(self) -> models.Ports | None:
        """How it is connected."""
        return self.compensator.ports if self.compensator else None

    @cached_property
    def friction(self) -> tuple[str, ...]:
        """Its parameters that are those of a friction law."""
        if self.law is not None:
            every = self.law.parameters.values()
            scalar = tuple(p.name for p in every if len(p.start) == 1 and p.start[0] > 0.0)
            return estimated(self.law) or scalar
        if not self.model or self.own_ports is not None:
            return ()
        own = {v.name for v in models.load_model(self.model).variables if v.role == "parameter"}
        return tuple(name for name in estimated(friction_law()) if name in own)

    @property
    def kept(self) -> list[str]:
        """Return the names of the variables of its model that it keeps between samples."""
        return [v.name for v in self._variables if v.role in ("state", "memory")]

    def elements(self, name: str) -> list[str]:
        """Return the names of the elements of an array, or a name that is no array."""
        return [one for one in self._units if one.partition("[")[0] == name] or [name]

    @property
    def learns(self) -> bool:
        """Whether the drive trains it: while it runs, or in experiments of its own."""
        return self.ports is not None and bool(self.ports.frozen or self.experiment)

    def genes(self, coarse: Coarse) -> list[ga.Gene]:
        """Return what is tuned: its own genes, then the parameters of friction."""
        found = [
            _gene(f"{self.name}.{name}", span, coarse.scale(self._unit(name)))
            for name, span in self.ranges.items()
        ]
        if self.learns:  # friction parameters are what it learns
            return found
        for name in self.friction:
            if name not in self.ranges:
                start = coarse.start(name, self.law)
                span = start / RANGE, start, min(start * RANGE, _known(name, self.law).high)
                found.append(_gene(f"{self.name}.{name}", span, 1.0))
        return found

    def parameters(
        self, genes: Mapping[str, float], loop: VelocityLoop, coarse: Coarse, sheet: Datasheet
    ) -> dict[str, float]:
        """Return the parameters of its FMU for values of its genes."""
        coarsely = {name: coarse.start(name, self.law) for name in self.friction}
        designed = DESIGNS[self.design](genes, loop, coarse, sheet) if self.design else genes
        fixed = {**self._fixed, **self.values}
        scaled = {
            name: value * coarse.scale(unit) if any(force_and_length(unit)) else value
            for name, value in fixed.items()
            for unit in [self._unit(name)]
        }
        return {**scaled, **coarsely, **designed}

    def _unit(self, name: str) -> str:
        return self._units.get(name, "1")

    @cached_property
    def _fixed(self) -> dict[str, float]:
        """Start values of its model that hold for the paper's stage, and nobody chooses."""
        kept = self.ports.axis if self.ports else {}
        return {
            v.name: float(v.start)
            for v in self._variables
            if v.role == "parameter" and v.start and v.name not in kept
            if any(force_and_length(v.unit or "1"))
        }

    @cached_property
    def _units(self) -> dict[str, str]:
        return {v.name: v.unit or "1" for v in self._variables}

    @cached_property
    def _variables(self) -> tuple[Variable, ...]:
        if not self.model or self.own_ports is not None:
            return ()
        return models.load_model(self.model, self.law.name if self.law else None).variables


@dataclass(frozen=True)
class Entrant:
    """A combination of parts, in the order in which their forces are added."""

    parts: tuple[Part, ...]

    @property
    def title(self) -> str:
        """The display names of its parts."""
        return " + ".join(part.title for part in self.parts)

    @property
    def chain(self) -> list[Compensator]:
        """Its compensators."""
        return [one for part in self.parts if (one := part.compensator) is not None]

    @property
    def positions(self) -> bool:
        """Whether it controls the position by itself, and needs no loop around it."""
        return any(part.positions for part in self.parts)

    def base(self, loop: VelocityLoop) -> VelocityLoop:
        """Return a designed velocity loop with what the entrant needs around it."""
        if not self.positions:
            return loop
        return loop.changed(m_ff=loop.axis.m, K_x=position_loop(loop).K_x)

    @property
    def learned(self) -> dict[str, str]:
        """Parameters that take over what a run has learned, and the variables that show it."""
        return {
            f"{part.name}.{element}": f"{part.name}.{element.replace(parameter, variable, 1)}"
            for part in self.parts
            if part.ports is not None
            for parameter, variable in part.ports.learned.items()
            for element in part.elements(parameter)
        }

    @property
    def frozen(self) -> dict[str, float]:
        """Parameters with which nothing is learned."""
        return {
            f"{part.name}.{name}": value
            for part in self.parts
            if part.ports is not None
            for name, value in part.ports.frozen.items()
        }

    def problem(self, coarse: Coarse) -> ga.Problem | None:
        """Return what is searched; None where nothing is."""
        genes = [gene for part in self.parts for gene in part.genes(coarse)]
        if not genes:
            return None
        names = {gene.name for gene in genes}
        pairs = [
            ga.AtLeast(f"{part.name}.{name}", f"{part.name}.{bound}")
            for part in self.parts
            for name in part.friction
            if (bound := _known(name, part.law).at_least)
        ]
        kept = tuple(one for one in pairs if {one.larger, one.smaller} <= names)
        return ga.Problem(genes, Repairs(kept) if kept else None)

    def tuned(
        self, genes: Mapping[str, float], loop: VelocityLoop, coarse: Coarse, sheet: Datasheet
    ) -> TunedEntrant:
        """Return loop and parameters of the chain for values of the genes; raise ControlError."""
        values, damping = dict[str, float](), dict[str, float]()
        loop = self.base(loop)
        for part in self.parts:
            prefix = f"{part.name}."
            own = {n.removeprefix(prefix): x for n, x in genes.items() if n.startswith(prefix)}
            if part.controller:
                gains = REGULATORS[part.design]({**part.values, **own}, loop)
                damping = {name: gains.pop(name) for name in DAMPING if name in gains}
                loop = regulated(loop, **gains)
            elif part.model:
                found = part.parameters(own, loop, coarse, sheet)
                values |= {f"{prefix}{name}": value for name, value in found.items()}
        return TunedEntrant(loop, values, damping)


@dataclass(frozen=True)
class Repairs:
    """Several constraints, one after the other."""

    pairs: tuple[ga.AtLeast, ...]

    def __call__(self, values: Any, genes: Sequence[ga.Gene]) -> Any:
        """Repair a population (n, k)."""
        for pair in self.pairs:
            values = pair(values, genes)
        return values


def _known(name: str, law: models.Law | None) -> models.LawParameter:
    """Return a parameter of a law, or that of any law for what contains none."""
    return law.parameters[name] if law else parameter(name)


def _gene(name: str, span: Sequence[float], scale: float) -> ga.Gene:
    low, start, high = (scale * value for value in span)
    return ga.Gene(name, low, high, start, linear=low <= 0.0)


@cache
def parts() -> dict[str, Part]:
    """Return all parts by name: those of ``entrants.toml``, then what enters without an entry."""
    tables = content()
    return {name: _part(name, tables.get(name)) for name in part_names()}


def default_names() -> list[str]:
    """Return the names of all entrants: parts, combinations, and both with tuned gains as well."""
    tables = content()
    alone = [name for name in part_names() if name not in tables["behind"]]
    names = [*alone, *tables["combinations"]]
    chains = {name: entrant(name).parts for name in names}
    plain = [n for n, chain in chains.items() if not any(p.controller for p in chain)]
    return [*names, *(f"pi+{name}" for name in plain if name != "none")]


def entrant(name: str, further: Mapping[str, Part] | None = None) -> Entrant:
    """Return an entrant by its name, of known parts and those of the user; raise UsageError."""
    known = {**parts(), **(further or {})}
    require_parts(name, further or ())
    found = Entrant(tuple(known[word] for word in name.split("+")))
    if len({part.name for part in found.parts}) < len(found.parts):
        raise UsageError(f"compensator '{name}': each part can be there once only")
    for part in found.parts:
        after = found.chain[1:]
        if part.compensator in after and "F_added" not in part.compensator.ports.inputs.values():
            raise UsageError(
                f"compensator '{name}': '{part.name}' must come first, because it cannot"
                " take the force of another one"
            )
    return found


def own_part(fmu: Path, ports: Path | Mapping[str, Any]) -> Part:
    """Return a compensator of the user from its FMU and how it is connected.

    Raises UsageError when the file is not well formed, or names what the FMU has not, or CosimError
    when the FMU cannot be read. The ports are a TOML file, or its content.
    """
    where = str(ports) if isinstance(ports, Path) else f"ports of {fmu.name}"
    try:
        table = parse_toml(read_limited(ports, MOST_TEXT)) if isinstance(ports, Path) else ports
    except ValueError as error:
        raise UsageError(f"{where}: {error}") from None
    if unknown := sorted(table.keys() - _EXPECTED.keys()):
        raise UsageError(
            f"{where}: '{unknown[0]}' is unknown; expected {', '.join(sorted(_EXPECTED))}"
        )
    if not {"inputs", "output"} <= table.keys():
        raise UsageError(f"{where}: expected inputs and output")
    for key, value in table.items():
        fits, expected = _EXPECTED[key]
        if not fits(value):
            raise UsageError(f"{where}: {key}: expected {expected}, got {value!r:.80}")
    inputs, axis, genes = (table.get(key, {}) for key in ("inputs", "axis", "genes"))
    learned, frozen = table.get("learned", {}), table.get("frozen", {})
    for key, words, known in (
        ("inputs", inputs.values(), ROLES),
        ("axis", (word for word in axis.values() if isinstance(word, str)), AXIS),
    ):
        if unknown := sorted(set(words) - known):
            raise UsageError(
                f"{where}: {key}: '{unknown[0]}' is unknown; expected {', '.join(sorted(known))}"
            )
    variables = cosim.Fmu(fmu).variables
    named = [*inputs, table["output"], *axis, *genes, *learned, *learned.values(), *frozen]
    if absent := [name for name in (*named, *table.get("values", {})) if name not in variables]:
        hint = suggestion(absent[0], variables)
        raise UsageError(f"{where}: {fmu.name} has no variable '{absent[0]}'{hint}")
    for name in (*axis, *genes, *learned, *frozen, *table.get("values", {})):
        if variables[name].causality != "parameter":
            raise UsageError(f"{where}: '{name}' is no parameter of {fmu.name}")
    for name, span in genes.items():
        three = len(span) == 3 and span[0] <= span[1] <= span[2] and span[0] < span[2]
        if not (three and np.isfinite(span).all()):
            raise UsageError(
                f"{where}: genes: {name}: expected [lowest, start, highest], got {span}"
            )
    for name, causality in (*((name, "input") for name in inputs), (table["output"], "output")):
        if variables[name].causality != causality:
            raise UsageError(f"{where}: '{name}' is no {causality} of {fmu.name}")
    name = re.sub(r"\W", "_", table.get("name", fmu.stem))
    if name in {*parts(), *COMPONENTS}:
        raise UsageError(f"{where}: the name '{name}' is taken; give another one as name")
    return Part(
        name,
        table.get("title", fmu.name),
        f"own_{name}",
        values=table.get("values", {}),
        ranges={gene: tuple(span) for gene, span in genes.items()},
        own_ports=models.Ports(
            inputs, table["output"], tuple(genes), axis, learned=learned, frozen=frozen
        ),
        own_fmu=fmu,
    )


def _part(name: str, table: Mapping[str, Any] | None) -> Part:
    if table is None and name in models.law_names():
        known = models.load_law(name)
        return Part(name, f"{known.title} feedforward", FEEDFORWARD, known)
    if table is None:
        model = models.load_model(name)
        return Part(name, model.title, name, ranges=_ranges(model))
    law = table.get("law")
    return Part(
        name,
        table["title"],
        table.get("model", ""),
        models.load_law(law) if law else None,
        values=table.get("values", {}),
        ranges={gene: tuple(span) for gene, span in table.get("genes", {}).items()},
        design=table.get("design", ""),
        controller=table.get("controller", False),
        positions=table.get("positions", False),
        experiment=table.get("experiment", ""),
    )


def _ranges(model: models.Model) -> dict[str, tuple[float, float, float]]:
    """Return ranges of the tuned parameters of a compensator without an entry."""
    assert model.ports is not None  # noqa: S101 - it is a compensator
    friction, found = estimated(friction_law()), {}
    for variable in model.variables:
        if variable.name in model.ports.tuned and variable.name not in friction:
            low, high = variable.minimum or 0.0, variable.maximum or np.inf
            start = variable.start
            if high > 1.0:  # not a share
                low, high = max(low, start / RANGE), min(high, start * RANGE)
            if low < high:
                found[variable.name] = low, start, high
    return found
