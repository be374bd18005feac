"""Run one FMU or one system of FMUs, from its file or from Python."""

from __future__ import annotations

import io
import math
import warnings
import zipfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

from stickslip import cosim
from stickslip.cosim import ParameterError, Table
from stickslip.cosim.signals.signals import Input
from stickslip.cosim.signals.tables import Inputs
from stickslip.errors import UsageError, number, with_settings
from stickslip.fmi.by_name import by_name
from stickslip.fmi.files import atomic_write
from stickslip.keywords import RunOptions, named

if TYPE_CHECKING:
    import pandas as pd

MEMBER = "extra/stickslip/input.csv"


def pack_input(package: Path, table: pd.DataFrame) -> None:
    """Add a table with a column ``time`` [s] and one per exposed input to an .ssp file.

    It lies in the package as ``extra/stickslip/input.csv``: a place that SSP 1.0 leaves to tools,
    so others open the package as before.
    """
    stream = io.BytesIO(package.read_bytes())
    with zipfile.ZipFile(stream, "a", zipfile.ZIP_DEFLATED) as archive:
        info = zipfile.ZipInfo(MEMBER, (1980, 1, 1, 0, 0, 0))
        info.compress_type = zipfile.ZIP_DEFLATED
        archive.writestr(info, table.to_csv(index=False, lineterminator="\n"))
    atomic_write(package, stream.getvalue())


def packed_input(package: Path) -> dict[str, Table]:
    """Return the signals of a package by exposed input; raise SignalError or SspError."""
    from stickslip.cosim.ssp.structure import Package  # late, for runs of one FMU

    file = Package.open(package).folder / MEMBER
    return Table.all_from_csv(file) if file.is_file() else {}


class IdleInputs(UserWarning):
    """Inputs of a run get no signal."""


_MOST = 8  # names in a warning
_STEPS = 500  # of a run for which no step is proposed


@named(RunOptions)
def simulate(
    path: cosim.System | cosim.Fmu | Path | str,
    *,
    parameters: Mapping[str, Any] | None = None,
    inputs: Inputs | None = None,
    **options: Unpack[RunOptions],
) -> cosim.Result:
    """Run a system, an FMU or a system structure package once and return what it recorded.

    Parameters
    ----------
    path : a system, an FMU, FILE.fmu or FILE.ssp
    start, stop, step : [s], instead of those that the file proposes; where it proposes no step, the
        smallest that its FMUs propose, or 1/500 of the time from start to stop
    parameters : start values by name, ``component.variable`` or, of one FMU, ``variable``: a
        dictionary, or a row of a table such as that of ``sweep``
    inputs : signals by exposed input, as of ``Simulation.run``: series over time [s], a data frame
        of them, arrays, functions of time [s] or numbers; an .ssp file may bring its own
    record : names or patterns such as ``drive.*``, or a Record; all outputs and inputs by default,
        or all variables of a system that has none
    coupling, constant_step, compiled, tolerance, allow_nan, isolation : as of ``System.prepare``

    Raises
    ------
    UsageError
        When the path has another suffix, or no stop time is given and the file proposes none.
    CosimError
        When the file cannot be read or the run fails.
    """
    model = Model.of(path)
    signals = model.signals(inputs)
    starts = by_name("parameters", parameters, UsageError)
    model.require_free(starts, signals)
    for name, value in starts.items():
        model.set(name, value)
    model.warn_of_idle(signals)
    with model.prepare(**options) as simulation:
        return simulation.run(inputs=signals)


@dataclass
class Model:
    """A system that was read from a file."""

    path: Path
    system: cosim.System
    experiment: cosim.DefaultExperiment  # times that the file proposes
    # signals that are packed with it, by exposed input
    inputs: Mapping[str, cosim.Table] = field(default_factory=dict)

    @classmethod
    def of(cls, source: cosim.System | cosim.Fmu | Path | str) -> Model:
        """Return a copy of a system, one of an FMU, or read a file."""
        if isinstance(source, cosim.System):
            return cls(Path(source.name), source.copy(), cosim.DefaultExperiment())
        if isinstance(source, cosim.Fmu):
            return cls._lone(source, source.path)
        return cls.open(Path(source))

    @classmethod
    def open(cls, path: Path, variant: str | None = None) -> Model:
        """Read FILE.fmu or FILE.ssp; ``variant`` names a system of an .ssp that has several."""
        if path.suffix == ".ssp":
            return cls(path, *cosim.read_ssp(path, variant), packed_input(path))
        if path.suffix != ".fmu":
            raise UsageError(f"{path}: expected a file .ssp or .fmu")
        if variant is not None:
            raise UsageError(f"{path}: a variant names a system of an .ssp; this is one FMU")
        return cls._lone(cosim.Fmu(path), path)

    @classmethod
    def _lone(cls, fmu: cosim.Fmu, path: Path) -> Model:
        system = cosim.System(path.stem)
        system.add(fmu.identifier, fmu)
        _expose_inputs(system)
        return cls(path, system, fmu.experiment)

    def prepare(
        self,
        *,
        start: float | None = None,
        stop: float | None = None,
        step: float | None = None,
        record: cosim.Record | Iterable[str] | None = None,
        **options: Any,
    ) -> cosim.Simulation:
        """Instantiate the FMUs for the times that are given or proposed; raise UsageError."""
        start = (self.experiment.start or 0.0) if start is None else start
        stop = self.experiment.stop if stop is None else stop
        if stop is None:
            raise UsageError(f"{self.path}: no stop time is proposed; give one in s: <stop S>")
        step = self.step(start, stop) if step is None else step
        record = self.record(record)
        try:
            return self.system.prepare(start=start, stop=stop, step=step, record=record, **options)
        except cosim.ExperimentError as fault:
            raise UsageError(f"{self.path}: {fault}") from fault

    def step(self, start: float, stop: float) -> float:
        """Return the step of a run from a start to a stop time [s].

        It is the one that the file proposes, else the smallest that its FMUs propose, reduced so
        that it divides the run, else 1/500 of the run.
        """
        if self.experiment.step is not None:
            return self.experiment.step
        duration = stop - start
        proposed = (one.experiment.step for one in self.system.components.values())
        least = min((step for step in proposed if step), default=None)
        if least is None or not 0.0 < least < duration < math.inf:
            return duration / _STEPS
        return duration / math.ceil(duration / least * (1.0 - 1e-9))

    def idle_inputs(self, inputs: Iterable[str]) -> dict[str, tuple[Any, str]]:
        """Return start value and unit of inputs that have neither signal, source nor set value."""
        system, sources, driven = self.system, self.system.sources(), {*inputs}
        found = {}
        for name, component in system.components.items():
            for variable in component.variables.values():
                key = f"{name}.{variable.name}"
                if variable.causality != "input" or key in system.parameters:
                    continue
                for element in system.variable(key).elements():
                    one = f"{name}.{element.name}"
                    source = sources.get(one)
                    live = source in driven if source in system.inputs else source is not None
                    if not live and one not in system.parameters:
                        found[source or one] = (element.start, system.unit(one) or "")
        return found

    def warn_of_idle(self, inputs: Iterable[str], *, components: bool = False) -> None:
        """Warn of exposed inputs, and of ``components``, that nothing drives."""
        found = {
            name: start
            for name, start in self.idle_inputs(inputs).items()
            if components or name in self.system.inputs
        }
        if found:
            shown = [f"{n} = {value} {unit}".rstrip() for n, (value, unit) in found.items()]
            names = ", ".join(shown[:_MOST]) + (", ..." if len(found) > _MOST else "")
            warnings.warn(
                f"inputs that stay at their start values: {names};"
                + with_settings(" give them signals by <input>, or constants by <set>"),
                IdleInputs,
                stacklevel=5,
            )

    def record(
        self, names: cosim.Record | Iterable[str] | None, every: int = 1, keep: str = "all"
    ) -> cosim.Record:
        """Return what to record; names are qualified.

        By default outputs and exposed inputs, and where there are no outputs, local variables.
        """
        if isinstance(names, cosim.Record):
            return names
        each = [names] if isinstance(names, str) else [] if names is None else [*names]
        qualified = [self.qualified(name) for name in each] or None
        return cosim.Record(qualified, every, keep)  # type: ignore[arg-type]

    @property
    def has_outputs(self) -> bool:
        """Whether a component has an output; else local variables are recorded."""
        parts = self.system.components.values()
        return any(v.causality == "output" for part in parts for v in part.variables.values())

    def signals(self, inputs: Inputs | None) -> dict[str, Input]:
        """Return the signals of a run: those that are given, else those packed with the file."""
        given = cosim.signals_of(self.inputs if inputs is None else inputs)
        found = {self.exposed(name): signal for name, signal in given.items()}
        if len(found) < len(given):
            raise UsageError(f"{self.path}: an input is given twice: {', '.join(given)}")
        return found

    def require_free(self, names: Iterable[str], signals: Iterable[str]) -> None:
        """Raise UsageError where a start value comes twice, or something drives what it is of."""
        seen = set[str]()
        for name in names:
            targets = self.system.inputs.get(name, (self.qualified(name),))
            for target in targets:
                if target in seen:
                    raise UsageError(f"a parameter comes twice: {target}")
                seen.add(target)
                source = self.system.connections.get(target)
                driven = (one for one in signals if target in self.system.inputs.get(one, ()))
                if source := source or next(driven, None):
                    raise UsageError(
                        f"{name}: a start value has no effect, because the input gets its values"
                        f" from {source}"
                    )

    def set(self, name: str, value: object) -> None:
        """Give a variable a start value, or the one that an exposed input is connected to."""
        target, *others = self.system.inputs.get(name, (self.qualified(name),))
        self.system.set(name if others else target, value)

    def start(self, name: str) -> float:
        """Return what a variable starts with; raise UsageError where that is no number."""
        target = self.target(name)
        value = self.system.parameters.get(
            target, self.system.variable(target, ParameterError).start
        )
        return number(f"{name}: its start value", value)

    def target(self, name: str) -> str:
        """Return what a start value is of, component.variable: of an exposed input, its first."""
        return self.system.inputs.get(name, (self.qualified(name),))[0]

    def qualified(self, name: str) -> str:
        """Return component.variable, also for a variable alone that one component has."""
        components = self.system.components
        if name.partition(".")[0] in components or name in self.system.inputs:
            return name
        having = [one for one in components if name in components[one].variables]
        if len(components) == 1 or len(having) == 1:
            return f"{[*having, *components][0]}.{name}"
        return name

    def exposed(self, column: str) -> str:
        """Return the input that a column names: itself, or the only variable that it drives."""
        if column in self.system.inputs:
            return column
        target = (self.qualified(column),)
        alone = (name for name, targets in self.system.inputs.items() if targets == target)
        if found := next(alone, None):
            return found
        flat = column.replace(".", "_")
        name, _, place = flat.removesuffix("]").partition("[")
        elements = [one for one in self.system.inputs if one.startswith(f"{name}[")]
        if place.isdecimal() and 0 < int(place) <= len(elements):
            return elements[int(place) - 1]
        return flat if flat in self.system.inputs else column


def _expose_inputs(system: cosim.System) -> None:
    """Expose the inputs of the only component, those that are arrays by element."""
    ((name, fmu),) = system.components.items()
    inputs = (v.name for v in fmu.variables.values() if v.causality == "input")
    for element in (e for v in inputs for e in system.variable(f"{name}.{v}").elements()):
        if element.is_signal:
            system.expose(element.name.replace(".", "_"), f"{name}.{element.name}")
