"""How components exchange values: method, inputs between points in time, step and rates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, get_args

from stickslip.cosim.errors import ExperimentError

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
            raise ExperimentError(
                f"tolerance {self.tolerance} and min_step {self.min_step} s must be positive"
            )


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
            raise ExperimentError(
                f"tolerance {self.tolerance} and max_iterations {self.max_iterations}"
                " must be positive"
            )
        if wrong := {c: n for c, n in self.every.items() if not (isinstance(n, int) and n > 0)}:
            raise ExperimentError(f"every holds {wrong}, expected positive integers")
        if self.every and (self.degree or self.adaptive):
            raise ExperimentError("several rates need degree 0 and a constant step")

    @classmethod
    def of(cls, coupling: Coupling | Method) -> Coupling:
        """Return a coupling given as itself or as the name of its method."""
        return coupling if isinstance(coupling, Coupling) else cls(coupling)

    @property
    def order(self) -> int:
        """The order of accuracy with FMUs that interpolate: the error falls with step^order.

        A quadratic extrapolation has no past in its first step, which costs it the third order.
        """
        return self.degree + 1 if self.method == "iterative" else min(self.degree + 1, 2)

    @property
    def is_plain(self) -> bool:
        """Whether inputs hold and every component does every step once."""
        return not (self.method == "iterative" or self.degree or self.adaptive or self.every)
