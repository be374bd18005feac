"""From a linear system to an FMU: its variables, its documentation and its matrices."""

import math
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.fmi.process import temporary_folder
from stickslip.fmi.toolchain import Platform
from stickslip.models.errors import LtiError
from stickslip.models.export.description import Kind, Model, Role, Variable
from stickslip.models.export.package import pack_fmu
from stickslip.models.export.sources import FmiVersion
from stickslip.models.lti.system import Array, LinearSystem, linear_system

# Axes and a step response.
_ICON = ((16, 14, 16, 82, 86, 82), (16, 82, 26, 56, 36, 34, 46, 27, 56, 31, 66, 36, 86, 36))
_README = """# {name}: a linear system

{equations}
{states} states{x0}, {time}.

| symbol | unit | meaning |
|---|---|---|
{rows}
"""
_EQUATIONS = {
    True: "    x+ = A x + B u\n     y = C x + D u\n",
    False: "    dx/dt = A x + B u\n        y = C x + D u\n",
}


def has_derivatives(system: LinearSystem) -> bool:
    """Tell whether there are differential equations with inputs: what Model Exchange is for."""
    return not system.dt and bool(system.states) and bool(system.inputs)


def model_of(system: LinearSystem, step: float, stop: float, folder: Path) -> Model:
    """Return the system as the exporter takes it; ``folder`` has its C and README.md."""
    shapes: dict[Role, tuple[str, int]] = {
        "input": ("u", len(system.inputs)),
        "state": ("x", len(system.states)),
        "derivative": ("x", len(system.states) * has_derivatives(system)),
        "output": ("y", len(system.outputs)),
    }
    fields: dict[Role, tuple[tuple[str, tuple[int, ...]], ...]] = {"memory": (), "parameter": ()}
    fields |= {role: ((name, (n,)),) if n else () for role, (name, n) in shapes.items()}
    if system.dt:
        fields["memory"] = (("k", ()), ("y", (len(system.outputs),)))
    return Model(
        name=system.name,
        title="Linear system",
        description=f"{len(system.states)} states, {_time(system)}",
        version="1.0",
        stop=stop,
        step=step,
        variables=tuple(_variables(system)),
        fields=fields,
        icon=_ICON,
        folder=folder,
    )


def readme(system: LinearSystem) -> str:
    """Return README.md: equations and variables."""
    kinds = {"input": system.inputs, "state": system.states, "output": system.outputs}
    return _README.format(
        name=system.name,
        equations=_EQUATIONS[bool(system.dt)],
        states=len(system.states),
        x0=f" beginning at {system.x0.tolist()}" if system.x0.any() else "",
        time=_time(system),
        rows="\n".join(
            f"| `{name}` | {unit or ''} | {kind} |"
            for kind, variables in kinds.items()
            for name, unit in variables.items()
        ),
    )


def _time(system: LinearSystem) -> str:
    return f"sampled every {system.dt:g} s" if system.dt else "in continuous time"


def _variables(system: LinearSystem) -> Iterator[Variable]:
    """Yield the variables in value-reference order."""
    yield Variable("time", "time", "Simulation time", unit="s")
    for name, unit in system.inputs.items():
        yield Variable(name, "input", "Input", unit=unit)
    kind = "discrete" if system.dt else "continuous"
    for (name, unit), start in zip(system.states.items(), system.x0, strict=True):
        yield Variable(name, "state", "State", unit=unit, start=float(start), variability=kind)
    if has_derivatives(system):
        for (name, unit), a, b in zip(system.states.items(), system.A, system.B, strict=True):
            rate, said = f"{unit}/s" if unit else None, f"Derivative of {name}"
            on = {**_gains(system.inputs, b), **_gains(system.states, a)}
            yield Variable(f"der({name})", "derivative", said, unit=rate, depends=on, of=name)
    for (name, unit), c, d in zip(system.outputs.items(), system.C, system.D, strict=True):
        by_state = _gains(system.states, c)
        moving = has_derivatives(system)
        on = {**_gains(system.inputs, d), **(by_state if moving else {})}
        uses = () if moving else tuple(by_state)
        yield Variable(name, "output", "Output", unit=unit, is_output=True, depends=on, uses=uses)
    if system.dt:
        memory = {"sample": "1"} | {f"held.{name}": unit for name, unit in system.outputs.items()}
        for name, unit in memory.items():
            yield Variable(name, "memory", "Between samples", unit=unit, variability="discrete")


def _gains(names: Mapping[str, str | None], row: Array) -> dict[str, Kind]:
    return {name: "constant" for name, gain in zip(names, row, strict=True) if np.any(gain)}


_HERE = Path(__file__).parent
_STEPS = 100_000  # at most
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
    platforms: Iterable[Platform | str] | str | None = None,
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
        what = f"at most {_LARGEST} can be in an FMU in continuous time; reduce or discretise it"
        raise LtiError(f"{system.name} has {len(system.A)} states, {what}")
    own_step, own_stop = _proposed(system)
    step = (own_step if step is None else step) if not system.dt else system.dt
    stop = own_stop if stop is None else stop
    if not (0.0 < step < float("inf") and 0.0 < stop < float("inf")):
        raise LtiError(f"{system.name}: step is {step} s and stop {stop} s; expected above 0")
    with temporary_folder("stickslip-lti-") as sources:
        source = _HERE / ("discrete.c" if system.dt else "continuous.c")
        (sources / "model.c").write_text(source.read_text(encoding="utf-8"), encoding="utf-8")
        (sources / "matrices.h").write_text(_matrices(system, step, held), encoding="utf-8")
        (sources / "README.md").write_text(readme(system), encoding="utf-8")
        model = model_of(system, step, stop, sources)
        return pack_fmu(model, folder, fmi=fmi, platforms=platforms)


def _matrices(system: LinearSystem, step: float, held: bool) -> str:
    """Return ``matrices.h``."""
    n, m, p = len(system.states), len(system.inputs), len(system.outputs)
    tables = {"A": system.A, "B": system.B, "C": system.C, "D": system.D}
    norm = 0.0
    if not system.dt:
        balance = _balance(system.A)
        norm = np.abs(system.A * balance / balance[:, None]).sum(axis=1).max(initial=0.0)
        tables |= _over(step, system, balance)
    lines = [
        f"enum {{ N = {n}, M = {m}, P = {p}, R = N + 1, HELD = {held:d} }};",
        f"#define STEP {step!r}",
        f"#define NORM {float(norm)!r}",
        f"#define STATES(s) {'((s)->x)' if n else '((double *)(s))'}",
        f"#define INPUTS(s) {'((s)->u)' if m else '((const double *)(s))'}",
        *(["#define HAS_DERIVATIVES"] if has_derivatives(system) else []),
        *(_table(name, matrix) for name, matrix in tables.items()),
    ]
    return "\n".join(["/* Generated. */", *lines, ""])


def _balance(A: Array) -> Array:
    """Return by what to scale the states (n,), powers of 2, so that rows and columns are alike."""
    if not len(A):
        return np.ones(0)
    from scipy.linalg import matrix_balance  # late, for those who start quickly

    return np.array(matrix_balance(A, permute=False, separate=True)[1][0])


def _over(step: float, system: LinearSystem, balance: Array) -> dict[str, Array]:
    """Return the scales, and by what A and B change the state over a step."""
    n, m = system.B.shape
    A, B = system.A * balance / balance[:, None], system.B / balance[:, None]
    scale = np.abs(B).max(initial=0.0) or 1.0
    rates = np.vstack([np.hstack([A, B / scale]), np.zeros((m, n + m))])
    change = balance[:, None] * _exponential(step * rates)[:n]
    return {"BALANCE": balance, "A_STEP": change[:, :n] / balance, "B_STEP": change[:, n:] * scale}


def _table(name: str, matrix: Array) -> str:
    numbers = ", ".join(repr(float(value)) for value in matrix.flat) or "0.0"
    return f"static const double {name}[] = {{{numbers}}};"


def _exponential(matrix: Array) -> Array:
    """Return e^matrix - 1, (n, n): what ``continuous.c`` does."""
    norm = float(np.abs(matrix).sum(axis=1).max(initial=0.0))
    squarings = max(0, math.ceil(math.log2(norm / 0.5))) if norm > 0.0 else 0
    part = matrix / 2.0**squarings
    series = np.eye(len(matrix))
    for n in range(14, 1, -1):
        series = np.eye(len(matrix)) + part @ series / n
    result = part @ series
    for _ in range(squarings):
        result = 2.0 * result + result @ result
    return np.asarray(result)


def _proposed(system: LinearSystem) -> tuple[float, float]:
    """Return step and duration [s]: powers of ten (samples, where it is discrete) by the poles."""
    poles = np.linalg.eigvals(system.A)
    if system.dt:
        moduli = np.abs(poles)
        rates = -np.log(moduli[moduli > 0.0]) / system.dt
        step = system.dt
    else:
        rates = -poles.real
        fastest = max(abs(poles), default=0.0)
        step = 10.0 ** math.floor(math.log10(0.3 / fastest)) if fastest > 0.0 else 1e-3
    slowest = min((r for r in abs(rates) if r > 1e-9 / step), default=0.01 / step)
    steps = 10 ** math.ceil(math.log10(min(max(5.0 / (slowest * step), 1.0), _STEPS)))
    return step, step * steps
