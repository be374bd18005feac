"""Components without a file: linear systems of python-control, Python functions, simple blocks.

>>> system = ss.System("loop")
>>> system.add("error", ss.blocks.sum("+-"))
>>> system.add("controller", lambda e, K=200.0: K * e)
>>> system.add("plant", control.tf([1.0], [5.0, 20.0], inputs="F", outputs="v"))

Linear systems, sums, gains and delays become FMUs, so they run natively and can be exported.
Functions, saturation and lookup tables run in Python, and in this process only.
"""

import inspect
from collections.abc import Callable, Mapping, Sequence
from functools import partial, update_wrapper
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip import cosim
from stickslip.errors import UsageError, number
from stickslip.fmi.by_name import by_name
from stickslip.fmi.files import atomic_write
from stickslip.fmi.messages import suggestion
from stickslip.fmi.process import temporary_folder
from stickslip.fmi.toolchain.platforms import cache_directory

__all__ = ["delay", "function", "gain", "linear", "lookup", "saturation", "sum"]

Units = Mapping[str, str]
_MOST = 300  # samples of a delay: each costs as much as a state


def linear(
    system: Any,
    *,
    name: str | None = None,
    units: Units | None = None,
    x0: ArrayLike | None = None,
    step: float | None = None,
    held: bool = False,
) -> cosim.Fmu:
    """Return a linear system as a component.

    Parameters
    ----------
    system : StateSpace or TransferFunction of python-control
    name, units, x0, step, held : as of ``ss.export_lti``

    Raises
    ------
    LtiError
        When it is not linear, or improper.
    """
    from stickslip.models import export_lti  # late, for those who add FMUs only

    with temporary_folder() as folder:
        return kept(export_lti(system, folder, name=name, units=units, x0=x0, step=step, held=held))


def kept(written: Path) -> cosim.Fmu:
    """Return an FMU as a component, from a copy among the built files that stays."""
    content = written.read_bytes()
    path = cache_directory() / "blocks" / sha256(content).hexdigest()[:16] / written.name
    return cosim.Fmu(path if path.exists() else atomic_write(path, content))


def function(step: Callable[..., float]) -> cosim.Function:
    """Return a Python function as a component: parameters are inputs, what it returns is ``y``.

    A parameter ``t`` is the time [s]; one with a default value keeps it and is no input.

    Raises
    ------
    UsageError
        When it takes any number of arguments; ``ss.Function`` declares inputs by name.
    """
    try:
        parameters = [*inspect.signature(step).parameters.values()]
    except ValueError:  # of some functions in C
        parameters = [inspect.Parameter("any", inspect.Parameter.VAR_POSITIONAL)]
    if any(one.kind not in (one.POSITIONAL_OR_KEYWORD, one.KEYWORD_ONLY) for one in parameters):
        name = getattr(step, "__qualname__", step)
        raise UsageError(f"{name}: its parameters do not name the inputs; use ss.Function")
    wanted = [one.name for one in parameters if one.default is one.empty]
    inputs = [name for name in wanted if name != "t"]
    return cosim.Function(_Function(step, timed="t" in wanted), dict.fromkeys(inputs), {"y": None})


class _Function:
    """A function of named inputs, called as ``cosim.Function`` does."""

    def __init__(self, step: Callable[..., float], *, timed: bool) -> None:
        update_wrapper(self, step)
        self.step, self.timed = step, timed

    def __call__(self, t: float, u: Mapping[str, float]) -> float:
        return self.step(**u, t=t) if self.timed else self.step(**u)


def gain(k: float, units: Units | None = None) -> cosim.Fmu:
    """Return y = k u.

    Parameters
    ----------
    units : of ``u`` and ``y`` by name; those of ``sum`` are of ``u1``, ``u2`` and so on

    Raises
    ------
    UsageError
        When k is not a number, or the units are of another name.
    """
    return _static("gain", ["u"], [number("k", k)], units)


def sum(signs: str = "++", units: Units | None = None) -> cosim.Fmu:  # noqa: A001 - its name
    """Return y = u1 + u2 for ``++``, u1 - u2 for ``+-``, and so on.

    Raises
    ------
    UsageError
        When there is another sign, or none.
    """
    if not isinstance(signs, str) or not signs or set(signs) - set("+-"):
        raise UsageError(f"signs are {signs!r}; expected one + or - for each input, such as +-")
    gains = [1.0 if sign == "+" else -1.0 for sign in signs]
    return _static("sum", [f"u{k}" for k in range(1, len(signs) + 1)], gains, units)


def delay(time: float, T_s: float, units: Units | None = None) -> cosim.Fmu:
    """Return y(t) = u(t - time), sampled every T_s [s]; 0 before.

    Where the source is stepped before it, a sample is that of the end of the step, as for all that
    is coupled without iteration.

    Raises
    ------
    UsageError
        When the time [s] is not 1 to 300 sample periods.
    """
    time, T_s = number("time", time), number("T_s", T_s)
    n = round(time / T_s) if T_s > 0.0 and np.isfinite(time / T_s) else 0
    if not 1 <= n <= _MOST or abs(n * T_s - time) > 1e-6 * T_s:
        raise UsageError(
            f"a delay of {time!r} s with a sample every {T_s!r} s; expected 1 to {_MOST} samples"
        )
    shift = {"A": np.eye(n, k=1), "B": np.eye(n, 1, 1 - n), "C": np.eye(1, n)}
    return _block("delay", ["u"], units, **shift, D=np.zeros((1, 1)), dt=T_s)


def saturation(low: float, high: float) -> cosim.Function:
    """Return u limited to low and high.

    Raises
    ------
    UsageError
        When low is not below high.
    """
    low, high = number("low", low), number("high", high)
    if not low < high:
        raise UsageError(f"limits are {low!r} and {high!r}; expected the lower one first")
    return _python("saturation", _clipped, low, high)


def lookup(x: ArrayLike, y: ArrayLike) -> cosim.Function:
    """Return y at u, linear between the points x (n,), constant beyond them.

    Raises
    ------
    UsageError
        When the numbers of points differ, are below 2 or not finite, or x does not rise.
    """
    try:
        points = np.array(x, dtype=float), np.array(y, dtype=float)
    except (TypeError, ValueError) as fault:
        raise UsageError(f"points: expected numbers ({fault})") from None
    shapes = {one.shape for one in points}
    if len(shapes) > 1 or points[0].ndim != 1 or len(points[0]) < 2:
        raise UsageError(f"points have shapes {[one.shape for one in points]}; expected (n,) each")
    if not (np.isfinite(points).all() and (np.diff(points[0]) > 0.0).all()):
        raise UsageError("points: expected finite numbers, and x that rises")
    return _python("lookup", _interpolated, *points)


def _clipped(low: float, high: float, _: float, u: Mapping[str, float]) -> float:
    return min(max(u["u"], low), high)


def _interpolated(x: Any, y: Any, _: float, u: Mapping[str, float]) -> float:
    return float(np.interp(u["u"], x, y))


def _python(name: str, step: Callable[..., float], *constants: Any) -> cosim.Function:
    made = cosim.Function(partial(step, *constants), {"u": None}, {"y": None})
    made.label = name
    return made


def _static(name: str, inputs: list[str], gains: list[float], units: Units | None) -> cosim.Fmu:
    nothing = {"A": np.zeros((0, 0)), "B": np.zeros((0, len(gains))), "C": np.zeros((1, 0))}
    return _block(name, inputs, units, **nothing, D=np.array([gains], dtype=float), dt=0.0)


def _block(
    name: str, inputs: Sequence[str], units: Units | None, *, dt: float, **matrices: Any
) -> cosim.Fmu:
    from stickslip.models import LinearSystem  # as in ``linear``

    states = [f"x[{k}]" for k in range(len(matrices["A"]))]
    names = [*inputs, "y", *states]
    given = by_name("units", units, UsageError)
    if wrong := [one for one in given if one not in names]:
        raise UsageError(f"units: there is no {wrong[0]!r}{suggestion(wrong[0], names)}")

    def with_units(names: Sequence[str]) -> dict[str, str | None]:
        return {one: given.get(one) for one in names}

    return linear(
        LinearSystem(
            name,
            **matrices,
            dt=dt,
            inputs=with_units(inputs),
            outputs=with_units(["y"]),
            states=with_units(states),
            x0=np.zeros(len(states)),
        )
    )


def component(thing: object) -> object:
    """Return a system of python-control or a Python function as a component, others as given."""
    if type(thing).__module__.partition(".")[0] == "control":
        return linear(thing)
    return function(thing) if callable(thing) else thing
