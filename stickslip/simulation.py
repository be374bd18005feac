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


class MissedSamples(UserWarning):
    """The step of a run does not divide a sample period."""


_EQUAL = 1e-6  # relative difference of a sample period and so many steps
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
            found = self.system.prepare(start=start, stop=stop, step=step, record=record, **options)
        except cosim.ExperimentError as fault:
            raise UsageError(f"{self.path}: {fault}") from fault
        self._warn_of_step(step, getattr(found.spec.coupling, "every", {}))
        return found

    def _warn_of_step(self, step: float, every: Mapping[str, int]) -> None:
        """Warn of parameters ``T_s`` in s, sample periods, that are not so many whole steps."""
        periods = (
            (name, variable)
            for name, component in self.system.components.items()
            for variable in component.variables.values()
            if variable.name.rpartition(".")[2] == "T_s"  # of a component, or of one in a container
        )
        for name, period in periods:
            if period.causality != "parameter" or period.unit != "s":
                continue
            key, own = f"{name}.{period.name}", step * every.get(name, 1)
            value = self.system.parameters.get(key, period.start)
            steps = value / own if isinstance(value, float) else 0.0
            if steps <= 0.0 or abs(steps - round(steps)) <= _EQUAL * steps:
                continue
            shorter = own * steps / math.ceil(steps)
            warnings.warn(
                f"the step of {name}, {own:.6g} s, is no divisor of its sample period {key} = "
                f"{own * steps:.6g} s, so that it samples late or not at all; choose "
                f"{shorter:.6g} s",
                MissedSamples,
                stacklevel=6,
            )

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

    def _idle_inputs(self, inputs: Iterable[str]) -> dict[str, bool]:
        """Return inputs without signal, source and set value, with their start values.

        True are those that are exposed, and all of a component of which none is driven.
        """
        found: dict[str, bool] = {}
        system, sources, driven = self.system, self.system.sources(), {*inputs}
        for name, component in system.components.items():
            live, idle = False, dict[str, bool]()
            for variable in component.variables.values():
                if variable.causality != "input":
                    continue
                for element in system.variable(f"{name}.{variable.name}").elements():
                    one = f"{name}.{element.name}"
                    source = sources.get(one)
                    if {one, f"{name}.{variable.name}"} & system.parameters.keys() or (
                        source in driven if source in system.inputs else source is not None
                    ):
                        live = True
                    else:
                        text = f"{source or one} = {element.start!s} {system.unit(one) or ''}"
                        idle[text.rstrip()] = source is not None
            found |= {text: exposed or not live for text, exposed in idle.items()}
        return found

    def warn_of_idle(self, inputs: Iterable[str], *, components: bool = False) -> None:
        """Warn of inputs that nothing drives: exposed ones, the only ones of a component, or all.

        Those others, which are given with ``components``, are often optional.
        """
        idle = self._idle_inputs(inputs)
        shown = [text for text in idle if idle[text]]
        if components:
            shown += [text for text in idle if not idle[text]]
        if shown:
            names = ", ".join(shown[:_MOST]) + (", ..." if len(shown) > _MOST else "")
            warnings.warn(
                f"inputs that stay at their start values: {names};"
                + with_settings(" give exposed ones signals by <input>, or any constants by <set>"),
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
        """Give a variable a start value, or all that an exposed input is connected to."""
        for target in self.system.inputs.get(name) or (self.qualified(name),):
            self.system.set(target, value)

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
        if (bare := column.partition(" [")[0]) != column and bare in self.system.inputs:
            raise UsageError(
                f"{self.path}: the column {column!r} has a unit; call it {bare!r}, with values in "
                f"{self.system.unit(bare) or 'the unit of that input'}"
            )
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
