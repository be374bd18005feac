"""A specification on its way to the child, which need not read the FMUs' descriptions again."""

from __future__ import annotations

import copyreg
import io
import pickle
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from stickslip.cosim.fmu.fmu import Fmu
from stickslip.cosim.signals.scenario import Scenario, Tables
from stickslip.cosim.signals.signals import Array, Input, sampled
from stickslip.cosim.system.system import Specification


class _Packer(pickle.Pickler):
    """Takes FMUs as they are, where a plain pickle is their path."""

    def reducer_override(self, thing: object) -> Any:
        if isinstance(thing, Fmu):
            return copyreg.__newobj__, (Fmu,), thing.__dict__  # type: ignore[attr-defined]
        if isinstance(thing, MappingProxyType):
            return _unchanging, (dict(thing),)
        return NotImplemented


def _unchanging(content: dict[Any, Any]) -> MappingProxyType[Any, Any]:
    return MappingProxyType(content)


def pack(specification: Specification, **more: object) -> bytes:
    """Return a specification, and what goes with it, as bytes for ``pickle``."""
    system = specification.system.copy()
    system.origin = None
    stream = io.BytesIO()
    plain = replace(specification, system=system, isolation=None)
    _Packer(stream, pickle.HIGHEST_PROTOCOL).dump({"specification": plain, **more})
    return stream.getvalue()


def portable_inputs(inputs: Mapping[str, Input], time: Array) -> dict[str, Input]:
    """Return inputs that another process understands: our signals as they are, others sampled."""
    return {
        name: signal if _is_portable(signal) else sampled(name, signal, time)
        for name, signal in inputs.items()
    }


def _is_portable(signal: Input) -> bool:
    if hasattr(signal, "sample"):
        return type(signal).__module__ == "stickslip.cosim.signals.signals"
    return isinstance(signal, int | float | np.ndarray)


@dataclass(frozen=True)
class Tabulated(Scenario):
    """A scenario as the tables that it makes."""

    made: Tables | None = None

    @classmethod
    def of(cls, scenario: Scenario | None, time: Array) -> Tabulated | None:
        """Return what a scenario does at the times (n,) in s, None for none."""
        return None if scenario is None else cls(made=scenario.tables(time))

    def tables(self, time: Array) -> Tables:  # noqa: ARG002 - they were made for these times
        """Return what happens."""
        return self.made or {}
