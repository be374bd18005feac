"""Keywords of runs, sweeps and searches, by which notebooks complete a call.

The process of an FMU imports this with ``stickslip.system``, so that it takes little of
``stickslip.cosim``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from inspect import Parameter, signature
from typing import TYPE_CHECKING, Any, Literal, TypedDict, TypeVar

from stickslip.arguments import checked
from stickslip.cosim.system.system import System

if TYPE_CHECKING:
    from stickslip import cosim
    from stickslip.cosim.signals.tables import Inputs


class RunOptions(TypedDict, total=False):
    """How a system is run; see ``simulate``."""

    start: float | None
    stop: float | None
    step: float | None
    record: cosim.Record | Iterable[str] | None
    coupling: cosim.Coupling | Literal["gauss_seidel", "jacobi", "iterative"]
    constant_step: bool
    compiled: bool
    tolerance: float | None
    allow_nan: bool
    isolation: cosim.Isolated


class SweepOptions(RunOptions, total=False):
    """How systems are run side by side; see ``sweep``."""

    inputs: Inputs | None
    workers: int
    where: str
    progress: Any


class SearchOptions(SweepOptions, total=False):
    """How a search runs systems; see ``optimise``."""

    evaluations: int
    algorithm: str
    seed: int


DEFAULTS: dict[str, Any] = {
    **{name: one.default for name, one in signature(System.prepare).parameters.items()},
    **dict.fromkeys(("start", "stop", "step", "inputs")),
    "workers": 1,
    "where": "threads",
    "progress": False,
    "evaluations": 300,
    "algorithm": "default",
    "seed": 0,
}
F = TypeVar("F", bound=Callable[..., object])


def named(options: type | Callable[..., object]) -> Callable[[F], F]:
    """Name keywords of a function in its signature in place of ``**options``, to be completed.

    They are the keys of a dictionary, or the keywords of another function.
    """
    if isinstance(options, type):
        more = [
            Parameter(name, Parameter.KEYWORD_ONLY, default=DEFAULTS[name]).replace(
                annotation=kind.__forward_arg__
            )
            for name, kind in options.__annotations__.items()
        ]
    else:
        every = signature(options).parameters.values()
        more = [one for one in every if one.kind is one.KEYWORD_ONLY]

    def changed(function: F) -> F:
        own = signature(function)
        parameters = [one for one in own.parameters.values() if one.kind is not one.VAR_KEYWORD]
        vars(function)["__signature__"] = own.replace(parameters=[*parameters, *more])
        return checked(function)

    return changed
