"""Runs of a system of our own FMUs in lanes: eight at once, each with the bits of the FMUs.

The C of the models is compiled for vectors, see ``models/lanes``. A run that fails there is left to
the FMUs, which say why.
"""

import logging
from collections.abc import Callable, Mapping, Sequence
from ctypes import CDLL, Structure, addressof, byref, c_double, c_int, c_int64, c_void_p
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from stickslip import cosim, models
from stickslip.cosim.assembly.plan import Plan
from stickslip.cosim.component import component_of
from stickslip.cosim.errors import CosimError
from stickslip.cosim.signals.signals import Array, Input
from stickslip.cosim.system.scaling import IDENTITY
from stickslip.fmi.toolchain import ToolchainError
from stickslip.models.lanes.library import model_library, run_library

_log = logging.getLogger(__name__)
LANES = 8
FEWEST = 3  # runs for which lanes are faster than the FMUs
_BLOCK = 64  # as in run.h


class Run(NamedTuple):
    """Arguments of ``cosim.Simulation.run``."""

    parameters: Mapping[str, object]
    inputs: Mapping[str, Input]
    until: float | None = None


Results = list[cosim.Result | None]
Each = Callable[[Callable[[Sequence[Run]], Results], list[list[Run]]], list[Results]]


class NoLanes(Exception):
    """Why only its FMUs can run a system."""


class _Component(Structure):
    _fields_ = (
        ("model", c_void_p),
        ("first", c_int64),
        ("wires", c_void_p),
        ("n_wires", c_int64),
        ("checked", c_void_p),
        ("n_checked", c_int64),
    )


class _LaneRun(Structure):
    _fields_ = (
        ("components", c_void_p),
        ("n_components", c_int64),
        ("start", c_double),
        ("step", c_double),
        ("constant_step", c_int64),
        ("n_external", c_int64),
        ("n_recorded", c_int64),
        *((name, c_void_p) for name in ("recorded", "values", "block", "external", "record")),
        ("room", c_int64),
        ("n_steps", c_void_p),
        ("failed", c_void_p),
    )


class Lanes:
    """A system whose runs go in lanes, in any number of threads; raises NoLanes otherwise."""

    def __init__(self, specification: cosim.Specification, level: int | None = None) -> None:
        self._plan = plan = Plan(specification)
        system, record = specification.system, plan.record
        plain = plan.coupling.is_plain and plan.coupling.method == "gauss_seidel"
        if not plain or any(one.iterated for one in plan.groups) or specification.allow_nan:
            raise NoLanes("it is coupled otherwise than lanes are")
        if record.every != 1 or record.keep != "all" or plan.layout.texts:
            raise NoLanes("it is recorded otherwise than lanes are")
        self._library, best = _runner()
        self._level = best if level is None else min(level, best)
        self._places: dict[str, int] = {}  # of each variable among the values
        self._whole: set[str] = set()  # those that are no real numbers
        starts: list[float] = []
        ranges, columns = [], {name: k for k, name in enumerate(system.inputs)}
        found, firsts = {}, {}
        for name, one in system.fmus("lanes").items():
            if (model := _model_of(one)) is None:
                raise NoLanes(f"{name} is not of our models")
            found[name] = model
        for name in plan.order:
            firsts[name], own = len(starts), system.components[name].variables
            for v in found[name].variables:
                self._places[f"{name}.{v.name}"] = len(starts)
                start: Any = own[v.name].start if v.name in own else None
                starts.append(float(v.start if start is None else start))
                is_set = v.role in ("parameter", "state", "input")
                ranges.append((v.minimum, v.maximum) if is_set else (None, None))
                if v.type != "real":
                    self._whole.add(f"{name}.{v.name}")
        self._starts = np.array(starts)
        self._low, self._high = (
            np.array([end if one is None else one for one in ends])[:, None]
            for end, ends in zip((-np.inf, np.inf), zip(*ranges, strict=True), strict=True)
        )
        self._components = (_Component * len(firsts))()
        self._tables = []  # which the components need
        for component, (name, first) in zip(self._components, firsts.items(), strict=True):
            wires = []
            for target, source in system.sources().items():
                if component_of(target) == name:
                    place = self._places[target]
                    bounded = np.isfinite([*self._low[place], *self._high[place]]).any()
                    if system.scaling(source, target) != IDENTITY or bounded:
                        raise NoLanes(f"{target} has a unit or range of its own")
                    wires.append((place, self._places.get(source, -1), columns.get(source, 0)))
            checked = [self._places[one] for one in plan.layout.outputs[name]]
            tables = [np.array(one, dtype=np.int64) for one in (wires, checked)]
            self._tables += tables
            law = found[name].law
            library = _loaded(found[name].name, law.name if law else None, self._level)
            component.model, component.first = library.lane_model(), first
            component.wires, component.checked = (one.ctypes.data for one in tables)
            component.n_wires, component.n_checked = len(wires), len(checked)
        self._names = plan.layout.recorded
        if not {*self._names} <= self._places.keys():
            raise NoLanes("it records its inputs")
        self._recorded = np.array([self._places[name] for name in self._names], dtype=np.int64)

    def run(self, runs: Sequence[Run], each: Each | None = None) -> Results:
        """Return the results, None if left to the FMUs; ``each`` maps runs of like lengths."""
        order = sorted(range(len(runs)), key=lambda k: -(runs[k].until or np.inf))
        split = np.array_split(np.array(order, dtype=int), max(1, -(-len(runs) // LANES)))
        parts = [part.tolist() for part in split if len(part) >= FEWEST]
        together = [[runs[k] for k in part] for part in parts]
        results = each(self._run, together) if each else map(self._run, together)
        found: Results = [None] * len(runs)
        for part, some in zip(parts, results, strict=True):
            for k, one in zip(part, some, strict=True):
                found[k] = one
        return found

    def _run(self, runs: Sequence[Run]) -> Results:
        """Run up to ``LANES``."""
        plan = self._plan
        spec, n_external = plan.spec, len(plan.spec.system.inputs)
        values = _vectors(len(self._starts))
        values[:] = self._starts[:, None]
        steps, failed = np.zeros((2, LANES), dtype=np.int64)
        external = []
        for lane, run in enumerate(runs):
            try:
                for name, value in self._checked(run.parameters).items():
                    values[self._places[name], lane] = value
                n = plan.step_at(run.until)
                external.append(self._external(run.inputs, values[:, lane], n))
                steps[lane] = n
            except (KeyError, TypeError, ValueError, CosimError):  # the FMUs say what is wrong
                external.append(np.empty(0))
        steps[~((values >= self._low) & (values <= self._high)).all(axis=0)] = 0
        room = steps.max() + 1
        record = [np.empty((len(self._names), room)) for _ in runs]
        block = _vectors(_BLOCK * (n_external + len(self._names)))
        call = _LaneRun(
            components=addressof(self._components),
            n_components=len(self._components),
            start=spec.start,
            step=spec.step,
            constant_step=spec.constant_step,
            n_external=n_external,
            n_recorded=len(self._names),
            recorded=self._recorded.ctypes.data,
            values=values.ctypes.data,
            block=block.ctypes.data,
            external=addressof(inputs := _addresses(external)),
            record=addressof(outputs := _addresses(record)),
            room=room,
            n_steps=steps.ctypes.data,
            failed=failed.ctypes.data,
        )
        self._library.run_lanes(byref(call), self._level)
        del inputs, outputs
        ends = np.where(failed, 0, steps)[: len(runs)] + 1
        return [
            cosim.Result(plan.time[:end], own[:, :end].T, self._names, spec.system)
            if end > 1
            else None
            for own, end in zip(record, ends.tolist(), strict=True)
        ]

    def _checked(self, parameters: Mapping[str, object]) -> dict[str, Any]:
        """Return the parameters of a run; those that are no real numbers are checked."""
        own: dict[str, Any] = {**self._plan.spec.system.parameters, **parameters}
        whole = self._plan.start_values({name: own[name] for name in self._whole & own.keys()})
        return own | {name: whole[name] for name in self._whole & own.keys()}

    def _external(self, inputs: Mapping[str, Input], values: Array, n: int) -> Array:
        """Return the exposed inputs (n + 1, number); raise ValueError without numbers."""
        exposed = self._plan.spec.system.inputs
        table = np.empty((n + 1, len(exposed)))
        for column, (name, targets) in enumerate(exposed.items()):
            given = np.asarray(inputs.get(name, values[self._places[targets[0]]]), dtype=float)
            table[:, column] = np.broadcast_to(given, (self._plan.n_steps + 1,))[: n + 1]
        if inputs.keys() - exposed.keys() or not np.isfinite(table).all():
            raise ValueError(f"{[*inputs]}")
        return table


def _vectors(n: int) -> Array:
    """Return room for vectors (n, LANES), aligned as the processor wants them."""
    room = np.empty(n * LANES + LANES)
    begin = -room.ctypes.data % (8 * LANES) // 8
    return room[begin : begin + n * LANES].reshape(n, LANES)


def _addresses(arrays: Sequence[Array]) -> Any:
    return (c_void_p * LANES)(*(one.ctypes.data for one in arrays))


def lanes_of(specification: cosim.Specification) -> Lanes | None:
    """Return the lanes of a system; None where only its FMUs can run it, which is logged."""
    try:
        return Lanes(specification)
    except NoLanes as reason:
        _log.info("%s: runs go one by one: %s", specification.system.name, reason)
        return None


_MODELS: dict[Path, models.Model | None] = {}  # by folder, which a hash of the content names


def _model_of(fmu: cosim.Fmu) -> models.Model | None:
    if fmu.folder not in _MODELS:
        _MODELS[fmu.folder] = models.model_of(fmu.path)
    return _MODELS[fmu.folder]


@cache
def _runner() -> tuple[CDLL, int]:
    """Return the library that runs systems, and the kind of this processor."""
    library = _library(run_library)
    library.run_lanes.argtypes, library.run_lanes.restype = (c_void_p, c_int), None
    return library, int(library.lanes_level())


@cache
def _loaded(name: str, law: str | None, level: int) -> CDLL:
    """Return the library of a model for one kind of processor."""
    model = models.load_model(name, law)
    library = _library(lambda: model_library(model, level))
    library.lane_model.argtypes, library.lane_model.restype = (), c_void_p
    return library


def _library(build: Callable[[], Path]) -> CDLL:
    try:
        return CDLL(str(build()))
    except (ToolchainError, models.ModelError) as error:
        raise NoLanes(str(error)) from error
