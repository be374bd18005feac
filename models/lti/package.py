"""From a linear system to an FMU."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import matrix_balance

from models.errors import LtiError
from models.export.description import Model, Role, Variable
from models.export.package import pack_fmu
from models.export.sources import FmiVersion
from models.lti.experiment import proposed
from models.lti.exponential import exponential
from models.lti.system import Array, LinearSystem, linear_system
from toolchain import Platform

_HERE = Path(__file__).parent
_ICON = (  # a step response
    (18, 16, 18, 82, 86, 82),
    (18, 82, 26, 62, 34, 42, 42, 32, 50, 32, 58, 38, 66, 42, 74, 41, 84, 40),
)
_LARGEST = 128  # states in continuous time: three matrices of that size lie on the stack


def export_lti(
    system: Any,
    folder: Path | str,
    *,
    name: str | None = None,
    units: Mapping[str, str] | None = None,
    x0: ArrayLike | None = None,
    step: float | None = None,
    stop: float | None = None,
    held: bool = False,
    fmi: FmiVersion = 2,
    platforms: Iterable[Platform] | None = None,
) -> Path:
    """Write a linear system as an FMU, ``folder/NAME.fmu``, and return the path.

    In continuous time the FMU is exact for an input that is held over a step, whatever the step;
    it is fast for ``step``. In discrete time it takes a sample every ``dt``, whatever the step. The
    names of inputs, outputs and states are those of the system.

    Parameters
    ----------
    system : StateSpace or TransferFunction of python-control, proper; or a LinearSystem, of which
        ``name``, ``units`` and ``x0`` are part
    folder : is made if it is absent
    name : of the FMU, an identifier; the system's own by default
    units : of inputs, outputs and states by name
    x0 : (n,) state at the start; 0 by default
    step, stop : that the FMU proposes [s]; chosen by the poles by default
    held : of discrete systems: an output with direct gain keeps the last sample until the next is
        taken, as a controller does; otherwise it shows the sample due, with the input known then
    fmi, platforms : as for ``build_fmu``

    Raises
    ------
    LtiError
        When the system cannot be one FMU; the message says why.
    toolchain.ToolchainError, OSError
    """
    if not isinstance(system, LinearSystem):
        system = linear_system(system, name=name, units=units, x0=x0)
    if not system.dt and len(system.A) > _LARGEST:
        raise LtiError(
            f"{system.name} has {len(system.A)} states, at most {_LARGEST} can be in an FMU in"
            " continuous time; reduce or discretise it"
        )
    own_step, own_stop = proposed(system)
    step = (own_step if step is None else step) if not system.dt else system.dt
    stop = own_stop if stop is None else stop
    if not (0.0 < step < float("inf") and 0.0 < stop < float("inf")):
        raise LtiError(f"{system.name}: step is {step} s and stop {stop} s; expected above 0")
    with tempfile.TemporaryDirectory(prefix="stickslip-lti-") as sources:
        source = _HERE / ("discrete.c" if system.dt else "continuous.c")
        Path(sources, "model.c").write_text(source.read_text(encoding="utf-8"), encoding="utf-8")
        Path(sources, "matrices.h").write_text(_matrices(system, step, held), encoding="utf-8")
        model = _model(system, step, stop, Path(sources))
        return pack_fmu(model, folder, fmi=fmi, platforms=platforms)


def _model(system: LinearSystem, step: float, stop: float, folder: Path) -> Model:
    variables = [Variable("time", "time", "Simulation time", unit="s")]
    for name, unit in system.inputs.items():
        variables.append(Variable(name, "input", "Input", unit=unit))
    for (name, unit), start in zip(system.states.items(), system.x0, strict=True):
        kind = "discrete" if system.dt else "continuous"
        variables.append(
            Variable(name, "state", "State", unit=unit, start=float(start), variability=kind)
        )
    for (name, unit), gains in zip(system.outputs.items(), system.D, strict=True):
        direct = [u for u, gain in zip(system.inputs, gains, strict=True) if gain]
        variables.append(
            Variable(
                name,
                "output",
                "Output",
                unit=unit,
                is_output=True,
                depends=dict.fromkeys(direct, "dependent"),
                uses=tuple(system.states),
            )
        )
    fields: dict[Role, tuple[tuple[str, tuple[int, ...]], ...]] = {
        "input": _array("u", len(system.inputs)),
        "state": _array("x", len(system.states)),
        "output": _array("y", len(system.outputs)),
        "memory": (),
        "parameter": (),
    }
    if system.dt:
        fields["memory"] = (("k", ()), ("y", (len(system.outputs),)))
        memory = {"sample": "1"} | {f"held.{name}": unit for name, unit in system.outputs.items()}
        for name, unit in memory.items():
            variables.append(
                Variable(name, "memory", "Between samples", unit=unit, variability="discrete")
            )
    time = f"sampled every {system.dt:g} s" if system.dt else "in continuous time"
    return Model(
        name=system.name,
        title="Linear system",
        description=f"{len(system.states)} states, {time}",
        stop=stop,
        step=step,
        variables=tuple(variables),
        fields=fields,
        folder=folder,
        icon=_ICON,
    )


def _matrices(system: LinearSystem, step: float, held: bool) -> str:
    """Return ``matrices.h``."""
    n, m, p = len(system.states), len(system.inputs), len(system.outputs)
    tables = {"A": system.A, "B": system.B, "C": system.C, "D": system.D}
    if not system.dt:
        tables |= _over(step, system)
    lines = [
        f"enum {{ N = {n}, M = {m}, P = {p}, R = N + 1, HELD = {held:d} }};",
        f"#define STEP {step!r}",
        f"#define STATES(s) {'((s)->x)' if n else '((double *)(s))'}",
        f"#define INPUTS(s) {'((s)->u)' if m else '((const double *)(s))'}",
        *(_table(name, matrix) for name, matrix in tables.items()),
    ]
    return "\n".join(["/* Generated. */", *lines, ""])


def _over(step: float, system: LinearSystem) -> dict[str, Array]:
    """Return how to balance A, and by what A and B change the state over a step."""
    n, m = system.B.shape
    balance: Array = np.ones(n)
    if n:
        balance = np.array(matrix_balance(system.A, permute=False, separate=True)[1][0])
    A, B = system.A * balance / balance[:, None], system.B / balance[:, None]
    scale = np.abs(B).max(initial=0.0) or 1.0
    rates = np.vstack([np.hstack([A, B / scale]), np.zeros((m, n + m))])
    change = balance[:, None] * exponential(step * rates)[:n]
    return {"BALANCE": balance, "A_STEP": change[:, :n] / balance, "B_STEP": change[:, n:] * scale}


def _array(name: str, n: int) -> tuple[tuple[str, tuple[int, ...]], ...]:
    return ((name, (n,)),) if n else ()


def _table(name: str, matrix: Array) -> str:
    numbers = ", ".join(repr(float(value)) for value in matrix.flat) or "0.0"
    return f"static const double {name}[] = {{{numbers}}};"
