"""Settings of a run: how components exchange values, what is kept, what isolated FMUs may take."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, Self, get_args

from stickslip.cosim.errors import ExperimentError
from stickslip.fmi.process.sandbox import Permissions

Method = Literal["gauss_seidel", "jacobi", "iterative"]


@dataclass(frozen=True)
class Adaptive:
    """Steps of their own length within each communication step, which is the longest.

    A step counts as good when the coupling signals end within ``tolerance`` of what was
    extrapolated from the steps before. Else the FMUs go back and try a shorter one.

    Attributes
    ----------
    tolerance : relative to the greater of a signal's value and nominal value
    min_step : s; a step as short as this counts as good. It is longer where rounding asks for it,
        4e-6 s at Unix time
    """

    tolerance: float = 1e-4
    min_step: float = 1e-9

    def __post_init__(self) -> None:
        if not (self.tolerance > 0 and self.min_step > 0):
            both = f"tolerance {self.tolerance} and min_step {self.min_step} s"
            raise ExperimentError(f"{both} must be positive")


@dataclass(frozen=True)
class Coupling:
    """How components exchange values.

    Attributes
    ----------
    method : ``gauss_seidel`` steps components in the order of their direct feedthrough, each seeing
        what was computed before it, and iterates algebraic loops; ``jacobi`` delays every
        connection by one step; ``iterative`` repeats the step until all connections agree at its
        end, which needs FMUs that can restore their state
    degree : of the polynomials through the last known points that inputs follow during a step:
        0 constant, 1 linear, 2 quadratic; by default 1 for ``iterative``, else 0. ``iterative``
        knows the end of the step and interpolates; the other methods extrapolate what is not
        computed yet. FMUs that interpolate their inputs and Model Exchange follow exactly. The
        others are given the mean over the step; where an output depends on an input directly, they
        do the last eighth of the step with its value at the end, if they can vary their step, else
        all of it. Inputs from outside are joined likewise; with degree 0 they hold. Degree 2 of
        ``iterative`` is of third order but adds energy to what oscillates, as no method of more
        than second order through past points is A-stable: at h w rad a step the amplitude grows by
        about (h w)^4 / 24 in each step, 1e15-fold in 1,000 steps at h w = 1. Degree 1 adds none
    tolerance : of what is iterated, relative to the greater of its value and its nominal value
    max_iterations : of one step
    adaptive : whether and how the step adapts
    every : component -> its communication step as a multiple of that of the run

    Raises
    ------
    ExperimentError
    """

    method: Method = "gauss_seidel"
    degree: int = -1
    tolerance: float = 1e-12
    max_iterations: int = 50
    adaptive: Adaptive | None = None
    every: Mapping[str, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.method not in get_args(Method):
            wanted = ", ".join(map(repr, get_args(Method)))
            raise ExperimentError(f"coupling is {self.method!r}, expected one of {wanted}")
        if self.degree == -1:  # held at its end, an input of an iterated step adds energy
            object.__setattr__(self, "degree", 1 if self.method == "iterative" else 0)
        if self.degree not in (0, 1, 2):
            raise ExperimentError(f"degree is {self.degree!r}, expected 0, 1 or 2")
        if not (self.tolerance > 0 and self.max_iterations > 0):
            both = f"tolerance {self.tolerance} and max_iterations {self.max_iterations}"
            raise ExperimentError(f"{both} must be positive")
        if wrong := {c: n for c, n in self.every.items() if not (isinstance(n, int) and n > 0)}:
            raise ExperimentError(f"every holds {wrong}, expected positive integers")
        if self.every and (self.degree or self.adaptive):
            raise ExperimentError("several rates need degree 0 and a constant step")

    @classmethod
    def of(cls, coupling: Coupling | Method) -> Coupling:
        """Return a coupling given as itself or as the name of its method."""
        return coupling if isinstance(coupling, Coupling) else cls(coupling)

    @property
    def is_plain(self) -> bool:
        """Whether inputs hold and every component does every step once."""
        return not (self.method == "iterative" or self.degree or self.adaptive or self.every)


@dataclass(frozen=True)
class Record:
    """What to keep of a run.

    >>> Record("drive.*", every=10)

    Attributes
    ----------
    names : name or pattern (``drive.*``), or several, of what to keep. A pattern stands for outputs
        and exposed inputs, a name for any variable. Left out, all outputs and exposed inputs
        are kept. Where no component has an output, local variables that can change stand for them.
        Strings, which are read after each step, become ``Result.texts``
    every : keep the points in time 0, every, 2 every, ... only. Where an FMU ends the run, the last
        point is kept as well
    keep : ``all`` these points in time; the ``last`` point of the run alone; or their ``range``,
        the least, the greatest and the last value of each signal, as a result of three rows

    Raises
    ------
    ExperimentError : when ``every`` or ``keep`` has another value
    """

    names: str | Sequence[str] | None = None
    every: int = 1
    keep: Literal["all", "last", "range"] = "all"

    def __post_init__(self) -> None:
        if isinstance(self.every, bool) or not isinstance(self.every, int) or self.every < 1:
            raise ExperimentError(f"record: every = {self.every!r}, expected an integer from 1 on")
        if self.keep not in ("all", "last", "range"):
            expected = "expected 'all', 'last' or 'range'"
            raise ExperimentError(f"record: keep = {self.keep!r}, {expected}")

    @classmethod
    def of(cls, what: Record | str | Sequence[str] | None) -> Record:
        """Return a record as it is, and one of names for names."""
        return what if isinstance(what, Record) else cls(what)

    @property
    def wanted(self) -> tuple[str, ...] | None:
        """Return the names and patterns; None for the usual."""
        if isinstance(self.names, str):
            return (self.names,)
        return None if self.names is None else tuple(self.names)


_MOST = 1e9  # of a time or of memory; 30 years or a petabyte


@dataclass(frozen=True)
class Isolation:
    """Run FMUs in a process of their own, within limits.

    Attributes
    ----------
    timeout : s on the clock that preparing, one run or closing may take; any time if None, as long
        as time goes on in the simulation, see ``patience``
    patience : s on the clock that one call before the first step, or one step, may take
    memory : MB (10^6 bytes) that the FMUs may take, on Linux
    allow : what the sandbox lets the FMUs do, on Linux: ``network``, ``exec`` (start programs),
        ``files=DIR`` (read and write all below a folder) and ``env=NAME`` (know a variable)

    Raises
    ------
    ExperimentError : when one is not positive, or something else is allowed
    """

    timeout: float | None = None
    patience: float = 30.0
    memory: float = 4096.0
    allow: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in ("timeout", "patience", "memory"):
            value = getattr(self, name)
            if value is not None and not 0 < value < _MOST:
                most = f" below {_MOST:g}" if value >= _MOST else ""
                what = f"{name} is {value}, expected a positive number{most}"
                raise ExperimentError(f"isolation: {what}")
        try:
            Permissions.of(self.allow)
        except ValueError as fault:
            raise ExperimentError(f"isolation: {fault}") from None

    @classmethod
    def of(cls, what: Isolated) -> Self | Isolation | None:
        """Return the settings behind a word, or raise ExperimentError."""
        if what is None or isinstance(what, Isolation):
            return what
        if what not in ("process", "foreign"):
            expected = "'foreign', 'process', Isolation() or None"
            raise ExperimentError(f"isolation is {what!r}, expected {expected}")
        return cls()


Isolated = Isolation | Literal["foreign", "process"] | None
"""Which FMUs live in a process of their own: ``process`` and an Isolation mean all and None means
none. ``foreign``, the default, means those systems with an FMU whose binary was not compiled by
this installation, on Linux; a system with Python functions stays in the calling process."""
